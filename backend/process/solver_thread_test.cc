#include "backend/process/solver_thread.h"

#include <gtest/gtest.h>
#include <poll.h>

#include <variant>

#include "backend/core/mapper.h"
#include "backend/test/world.h"

namespace gw::backend {
namespace {

LocalBaJob MakeJob() {
  World world(WorldOptions{});
  Mapper mapper = Mapper::Create({}, {}, TestCamera()).value();
  for (int k = 0; k < 4; ++k) mapper.Insert(world.Make(k, mapper.map()));
  return *mapper.BuildJob();
}

// The outcome, as the node waits for it.
template <typename Result>
Result WaitFor(SolverThread& solver) {
  pollfd ready{solver.fd(), POLLIN, 0};
  EXPECT_EQ(::poll(&ready, 1, 60'000), 1);
  const auto outcome = solver.Take();
  const Result* result = outcome ? std::get_if<Result>(&*outcome) : nullptr;
  EXPECT_NE(result, nullptr);
  return result == nullptr ? Result() : *result;
}

TEST(SolverThread, SolvesOneJobAfterTheOtherAsTheSolverDoes) {
  const LocalBaJob job = MakeJob();
  const LocalBaResult expected = SolveLocalBa(job);
  SolverThread solver;
  EXPECT_FALSE(solver.busy());
  EXPECT_FALSE(solver.Take());
  for (int i = 0; i < 5; ++i) {
    solver.Start(job);
    EXPECT_TRUE(solver.busy());
    const auto result = WaitFor<LocalBaResult>(solver);
    EXPECT_FALSE(solver.busy());
    EXPECT_TRUE(result.usable);
    EXPECT_EQ(result.cost_after, expected.cost_after);
    ASSERT_EQ(result.keyframes.size(), expected.keyframes.size());
    for (size_t k = 0; k < result.keyframes.size(); ++k) {
      EXPECT_EQ(result.keyframes[k].T_WC.translation(), expected.keyframes[k].T_WC.translation());
    }
    // What was taken no longer wakes the node.
    pollfd ready{solver.fd(), POLLIN, 0};
    EXPECT_EQ(::poll(&ready, 1, 0), 0);
  }
}

TEST(SolverThread, SolvesTheGraphOfALoop) {
  LoopGraphJob job;
  job.ids = {{1}};
  job.graph.nodes.push_back({SE3(), true});
  SolverThread solver;
  solver.Start(job);
  const auto result = WaitFor<LoopGraphResult>(solver);
  EXPECT_TRUE(result.graph.usable);
  EXPECT_EQ(result.T_correction.size(), 1u);
}

TEST(SolverThread, SolvesTheNextJobAfterOneWasAbandoned) {
  const LocalBaJob job = MakeJob();
  SolverThread solver;
  solver.Start(job);
  solver.Abandon();
  WaitFor<LocalBaResult>(solver);  // whether or not it was solved before that
  solver.Start(job);
  EXPECT_TRUE(WaitFor<LocalBaResult>(solver).usable);
}

TEST(SolverThread, EndsWhileAJobRunsOrItsResultWaits) {
  const LocalBaJob job = MakeJob();
  {
    SolverThread solver;
    solver.Start(job);
  }
  SolverThread solver;
  solver.Start(job);
  pollfd ready{solver.fd(), POLLIN, 0};
  EXPECT_EQ(::poll(&ready, 1, 60'000), 1);
}

}  // namespace
}  // namespace gw::backend

#include "tools/lab/eval/align.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/lab/eval/test_trajectories.h"

namespace gw::eval {
namespace {

using testing::HasSubstr;

std::vector<PosePair> PairUp(const Trajectory& ref, const Trajectory& est) {
  return Associate(ref, est, Milliseconds(100), Milliseconds(20));
}

double SquaredError(const std::vector<PosePair>& pairs, const SE3& T_RefEst) {
  double sum = 0;
  for (const PosePair& pair : pairs) {
    sum += (pair.T_ref.translation() - T_RefEst * pair.T_est.translation()).squaredNorm();
  }
  return sum;
}

TEST(Associate, InterpolatesTheReferenceAtTheTimeOfTheEstimate) {
  const auto pairs = PairUp({At(1.00, 0, 0), At(1.10, 1, 0)}, {At(1.025, 9, 9)});
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_NEAR(pairs[0].T_ref.translation().x(), 0.25, 1e-12);
  EXPECT_EQ(pairs[0].utime, UtimeFromSeconds(1.025));
}

TEST(Associate, TakesASampleAtTheSameTimeAsItIs) {
  const auto pairs = PairUp({At(1, 0.1, 0.7), At(1.1, 1, 0)}, {At(1, 9, 9)});
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].T_ref.translation(), Eigen::Vector3d(0.1, 0.7, 0));
}

TEST(Associate, UsesOnlyNearSamplesWhereTheReferenceHasAHole) {
  const Trajectory ref = {At(1, 0, 0), At(2, 1, 0)};
  const auto pairs = PairUp(ref, {At(0.97, 1, 0), At(0.99, 2, 0), At(1.02, 3, 0), At(1.03, 4, 0),
                                  At(1.985, 5, 0), At(2.02, 6, 0), At(2.03, 7, 0)});
  ASSERT_EQ(pairs.size(), 4u);
  EXPECT_EQ(pairs[0].T_est.translation().x(), 2);
  EXPECT_EQ(pairs[1].T_est.translation().x(), 3);
  EXPECT_EQ(pairs[1].T_ref.translation().x(), 0);
  EXPECT_EQ(pairs[2].T_est.translation().x(), 5);
  EXPECT_EQ(pairs[2].T_ref.translation().x(), 1);
  EXPECT_EQ(pairs[3].T_est.translation().x(), 6);
}

TEST(Align, Se3FindsAnyRigidMotion) {
  const Trajectory ref = Eight(200, 0.1);
  for (int i = 0; i < 200; ++i) {
    CounterRng rng(1, 0, i);
    const SE3 T_RefEst = RandomPose(rng);
    const auto found = Align(PairUp(ref, Moved(T_RefEst.inverse(), ref)), Alignment::kSe3);
    ASSERT_TRUE(found.ok());
    EXPECT_LT((T_RefEst.inverse() * *found).Log().norm(), 1e-9) << "case " << i;
  }
}

TEST(Align, Se3WorksOnThePlaneAndNeverMirrors) {
  Trajectory ref = Eight(100, 0.1);
  for (TimedPose& pose : ref) {
    const Eigen::Vector3d p = pose.T.translation();
    pose.T = SE3(pose.T.rotation(), {p.x(), p.y(), 0});
  }
  for (int i = 0; i < 100; ++i) {
    CounterRng rng(2, 0, i);
    const SE3 T_RefEst = RandomPose(rng);
    const auto found = Align(PairUp(ref, Moved(T_RefEst.inverse(), ref)), Alignment::kSe3);
    ASSERT_TRUE(found.ok());
    EXPECT_LT((T_RefEst.inverse() * *found).Log().norm(), 1e-9) << "case " << i;
  }
}

TEST(Align, YawFindsATurnAboutZAndAShift) {
  const Trajectory ref = Eight(200, 0.1);
  for (int i = 0; i < 200; ++i) {
    CounterRng rng(3, 0, i);
    const SE3 T_RefEst(ExpSO3({0, 0, rng.Uniform(-3.1, 3.1)}),
                       {rng.Uniform(-9, 9), rng.Uniform(-9, 9), rng.Uniform(-9, 9)});
    const auto found = Align(PairUp(ref, Moved(T_RefEst.inverse(), ref)), Alignment::kYaw);
    ASSERT_TRUE(found.ok());
    EXPECT_LT((T_RefEst.inverse() * *found).Log().norm(), 1e-9) << "case " << i;
  }
}

// With noise there is no exact answer, but any other motion must be worse.
TEST(Align, IsALocalMinimumOfTheSquaredError) {
  for (int i = 0; i < 100; ++i) {
    CounterRng rng(4, 0, i);
    const Trajectory ref = Eight(60, 0.3);
    Trajectory est = Moved(RandomPose(rng), ref);
    for (TimedPose& pose : est) {
      const Eigen::Vector3d noise(rng.Normal(), rng.Normal(), rng.Normal());
      pose.T = SE3(pose.T.rotation(), pose.T.translation() + 0.3 * noise);
    }
    const auto pairs = PairUp(ref, est);
    for (const Alignment alignment : {Alignment::kSe3, Alignment::kYaw}) {
      const auto found = Align(pairs, alignment);
      ASSERT_TRUE(found.ok());
      const double best = SquaredError(pairs, *found);
      for (int axis = 0; axis < 6; ++axis) {
        const bool free = alignment == Alignment::kSe3 || axis < 3 || axis == 5;
        for (const double step : {-1e-3, 1e-3}) {
          Vector6d d = Vector6d::Zero();
          d[axis] = step;
          if (!free) continue;
          EXPECT_GT(SquaredError(pairs, SE3(SE3::Exp(d).rotation() * found->rotation(),
                                            SE3::Exp(d) * found->translation())),
                    best)
              << "case " << i << " axis " << axis;
        }
      }
    }
  }
}

TEST(Align, SaysWhatIsNotDetermined) {
  Trajectory line;
  Trajectory still;
  for (int i = 0; i < 20; ++i) {
    line.push_back(At(i, 0.6 * i, 0.8 * i));
    still.push_back(At(i, 1, 2));
  }
  const auto message = [](const Trajectory& t, Alignment alignment) {
    const auto found = Align(PairUp(t, t), alignment);
    return found.ok() ? std::string("ok") : found.error().message;
  };
  EXPECT_THAT(message(line, Alignment::kSe3), HasSubstr("lie on a line"));
  EXPECT_EQ(message(line, Alignment::kYaw), "ok");
  EXPECT_EQ(message(line, Alignment::kNone), "ok");
  EXPECT_THAT(message(still, Alignment::kSe3), HasSubstr("in one place"));
  EXPECT_THAT(message(still, Alignment::kYaw), HasSubstr("in one place"));
  EXPECT_EQ(message(still, Alignment::kNone), "ok");
  EXPECT_THAT(message({At(1, 2, 3)}, Alignment::kSe3), HasSubstr("only one pose"));
  EXPECT_EQ(message({At(1, 2, 3)}, Alignment::kNone), "ok");
  EXPECT_THAT(message({}, Alignment::kNone), HasSubstr("no pose of the estimate"));
}

}  // namespace
}  // namespace gw::eval

#include "backend/process/solver_thread.h"

#include <sys/eventfd.h>
#include <sys/resource.h>
#include <unistd.h>

#include <exception>
#include <utility>

#include "common/core/check.h"

namespace gw::backend {
namespace {

constexpr int kNicer = 5;  // than the rest: about a third of its share of a core that both want

}  // namespace

SolverThread::SolverThread() : event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  GW_CHECK(event_.get() >= 0);
  thread_ = std::thread([this] { Run(); });
}

SolverThread::~SolverThread() {
  Abandon();
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void SolverThread::Start(Job job) {
  GW_CHECK(!busy_);
  busy_ = true;
  abandon_ = false;
  {
    const std::lock_guard lock(mutex_);
    job_ = std::move(job);
  }
  wake_.notify_one();
}

std::optional<SolverThread::Outcome> SolverThread::Take() {
  const std::lock_guard lock(mutex_);
  if (!outcome_) return std::nullopt;
  eventfd_t count;
  eventfd_read(event_.get(), &count);
  busy_ = false;
  return std::exchange(outcome_, std::nullopt);
}

SolverThread::Outcome SolverThread::Solve(const Job& job) {
  if (const auto* graph = std::get_if<LoopGraphJob>(&job)) {
    try {
      return SolveLoopGraph(*graph);
    } catch (const std::exception&) {
      return LoopGraphResult();  // not usable
    }
  }
  const auto& bundle = std::get<LocalBaJob>(job);
  try {
    return SolveLocalBa(bundle, [this] { return abandon_.load(); });
  } catch (const std::exception&) {
    LocalBaResult failed;  // not usable; the mapper counts it
    failed.revision = bundle.revision;
    failed.newest = bundle.newest;
    return failed;
  }
}

void SolverThread::Run() {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), getpriority(PRIO_PROCESS, 0) + kNicer);
  while (true) {
    std::optional<Job> job;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stop_ || job_; });
      if (stop_) return;
      job = std::exchange(job_, std::nullopt);
    }
    Outcome outcome = Solve(*job);
    const std::lock_guard lock(mutex_);
    outcome_ = std::move(outcome);
    eventfd_write(event_.get(), 1);
  }
}

}  // namespace gw::backend

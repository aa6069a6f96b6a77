#include "backend/process/solver_thread.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <exception>
#include <utility>

#include "common/core/check.h"

namespace gw::backend {

SolverThread::SolverThread() : event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  GW_CHECK(event_.get() >= 0);
  thread_ = std::thread([this] { Run(); });
}

SolverThread::~SolverThread() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void SolverThread::Start(LocalBaJob job) {
  GW_CHECK(!busy_);
  busy_ = true;
  {
    const std::lock_guard lock(mutex_);
    job_ = std::move(job);
  }
  wake_.notify_one();
}

std::optional<LocalBaResult> SolverThread::Take() {
  const std::lock_guard lock(mutex_);
  if (!result_) return std::nullopt;
  eventfd_t count;
  eventfd_read(event_.get(), &count);
  busy_ = false;
  return std::exchange(result_, std::nullopt);
}

void SolverThread::Run() {
  while (true) {
    std::optional<LocalBaJob> job;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stop_ || job_; });
      if (stop_) return;
      job = std::exchange(job_, std::nullopt);
    }
    LocalBaResult result;
    try {
      result = SolveLocalBa(*job);
    } catch (const std::exception&) {
      // Not usable; the mapper counts it.
      result = LocalBaResult();
      result.revision = job->revision;
      result.newest = job->newest;
    }
    const std::lock_guard lock(mutex_);
    result_ = std::move(result);
    eventfd_write(event_.get(), 1);
  }
}

}  // namespace gw::backend

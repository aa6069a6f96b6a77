// One worker that solves the back-end's long jobs while the node goes on with its messages.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <variant>

#include "backend/core/bundle/local_ba.h"
#include "backend/core/loop/loop_closer.h"
#include "common/process/file_handle.h"

namespace gw::backend {

class SolverThread {
 public:
  using Job = std::variant<LocalBaJob, LoopGraphJob>;
  using Outcome = std::variant<LocalBaResult, LoopGraphResult>;  // of the same index

  SolverThread();
  ~SolverThread();  // abandons the job that runs and waits for it
  SolverThread(const SolverThread&) = delete;
  SolverThread& operator=(const SolverThread&) = delete;

  // Precondition: not busy().
  void Start(Job job);
  // A job was started and its outcome not taken yet.
  bool busy() const { return busy_; }
  // Bundle adjustment ends early; its outcome is not usable, but has still to be taken.
  void Abandon() { abandon_ = true; }
  // The outcome, once it is there. Clears fd().
  std::optional<Outcome> Take();
  // Readable when an outcome waits.
  int fd() const { return event_.get(); }

 private:
  void Run();
  Outcome Solve(const Job& job);

  process::FileHandle event_;
  bool busy_ = false;  // owner's side only
  std::atomic<bool> abandon_ = false;

  std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<Job> job_;
  std::optional<Outcome> outcome_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace gw::backend

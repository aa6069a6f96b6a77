// One worker that solves local BA jobs while the node goes on with its messages.
#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "backend/core/local_ba.h"
#include "common/process/file_handle.h"

namespace gw::backend {

class SolverThread {
 public:
  SolverThread();
  ~SolverThread();  // waits for the job that runs
  SolverThread(const SolverThread&) = delete;
  SolverThread& operator=(const SolverThread&) = delete;

  // Precondition: not busy().
  void Start(LocalBaJob job);
  // A job was started and its result not taken yet.
  bool busy() const { return busy_; }
  // The result, once it is there. Clears fd().
  std::optional<LocalBaResult> Take();
  // Readable when a result waits.
  int fd() const { return event_.get(); }

 private:
  void Run();

  process::FileHandle event_;
  bool busy_ = false;  // owner's side only

  std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<LocalBaJob> job_;
  std::optional<LocalBaResult> result_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace gw::backend

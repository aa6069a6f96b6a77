// What a process waits for: messages, a tick, the signal to stop, its devices.
#pragma once

#include <vector>

#include "common/core/result.h"
#include "common/core/time.h"
#include "common/process/file_handle.h"

namespace gw::process {

// SIGINT and SIGTERM arrive here instead of killing the process. They are blocked in the thread
// that calls Create and in those it starts later; create the Loop before any other thread.
class Loop {
 public:
  struct Ready {
    bool stop = false;  // finish the step, flush, exit 0
    bool tick = false;
    std::vector<int> fds;  // the watched ones that can be read, or have failed
  };

  // tick: period; late ticks are merged into one.
  static Result<Loop> Create(DurationUs tick);

  // The descriptor stays the caller's; it must be unwatched before it is closed.
  void Watch(int fd) { watched_.push_back(fd); }
  void Unwatch(int fd) { std::erase(watched_, fd); }

  // Blocks until something is ready.
  Result<Ready> Wait();

 private:
  Loop(FileHandle signals, FileHandle timer)
      : signals_(std::move(signals)), timer_(std::move(timer)) {}

  FileHandle signals_;
  FileHandle timer_;
  std::vector<int> watched_;
};

}  // namespace gw::process

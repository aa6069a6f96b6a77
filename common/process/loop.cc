#include "common/process/loop.h"

#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <sys/timerfd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace gw::process {
namespace {

Error SystemError(const char* what) {
  return {ErrorCode::kIo, std::string(what) + ": " + std::strerror(errno)};
}

}  // namespace

Result<Loop> Loop::Create(DurationUs tick) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  if (::pthread_sigmask(SIG_BLOCK, &set, nullptr) != 0) return SystemError("cannot block signals");
  FileHandle signals(::signalfd(-1, &set, SFD_NONBLOCK | SFD_CLOEXEC));
  if (!signals.valid()) return SystemError("cannot receive signals");

  FileHandle timer(::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC));
  const timespec period{tick.us / 1'000'000, tick.us % 1'000'000 * 1000};
  const itimerspec spec{period, period};
  if (!timer.valid() || ::timerfd_settime(timer.get(), 0, &spec, nullptr) != 0) {
    return SystemError("cannot start the timer");
  }
  return Loop(std::move(signals), std::move(timer));
}

Result<Loop::Ready> Loop::Wait() {
  std::vector<pollfd> fds{{signals_.get(), POLLIN, 0}, {timer_.get(), POLLIN, 0}};
  for (const int fd : watched_) fds.push_back({fd, POLLIN, 0});
  while (::poll(fds.data(), fds.size(), -1) < 0) {
    if (errno != EINTR) return SystemError("cannot wait for messages");
  }
  Ready ready;
  signalfd_siginfo signal;
  ready.stop = ::read(signals_.get(), &signal, sizeof(signal)) > 0;
  uint64_t expirations = 0;
  ready.tick = ::read(timer_.get(), &expirations, sizeof(expirations)) > 0;
  for (size_t i = 2; i < fds.size(); ++i) {
    if (fds[i].revents != 0) ready.fds.push_back(fds[i].fd);
  }
  return ready;
}

}  // namespace gw::process

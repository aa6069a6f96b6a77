#include "common/process/clock.h"

#include <unistd.h>

#include <ctime>
#include <fstream>

namespace gw::process {
namespace {

int64_t ReadUs(clockid_t id) {
  timespec time{};
  ::clock_gettime(id, &time);
  return int64_t{time.tv_sec} * 1'000'000 + time.tv_nsec / 1000;
}

}  // namespace

Clock::Clock(const std::string& offset_file) {
  shared_ = static_cast<bool>(std::ifstream(offset_file) >> offset_us_);
  if (shared_) return;
  offset_us_ = ReadUs(CLOCK_REALTIME) - ReadUs(CLOCK_MONOTONIC);
  // Several processes may start at once: each writes its own file, the first link wins.
  const std::string own = offset_file + "." + std::to_string(::getpid());
  std::ofstream(own) << offset_us_ << '\n';
  (void)::link(own.c_str(), offset_file.c_str());
  (void)::unlink(own.c_str());
  int64_t winner = 0;
  shared_ = static_cast<bool>(std::ifstream(offset_file) >> winner);
  if (shared_) offset_us_ = winner;
}

Utime Clock::Now() const {
  return {ReadUs(CLOCK_MONOTONIC) + offset_us_};
}

}  // namespace gw::process

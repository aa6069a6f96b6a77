#include "test/emulators/kobuki/pty_base.h"

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace gw::kobuki {
namespace {

Utime SteadyNow() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return {std::chrono::duration_cast<std::chrono::microseconds>(now).count()};
}

Error SystemError(const std::string& what) {
  return {ErrorCode::kIo, what + ": " + std::strerror(errno)};
}

}  // namespace

PtyBase::PtyBase(const EmulatorConfig& config, std::string link)
    : link_(std::move(link)), emulator_([&] {
        EmulatorConfig started = config;
        started.start = SteadyNow();
        return Emulator(started);
      }()) {}

Result<std::unique_ptr<PtyBase>> PtyBase::Create(const EmulatorConfig& config,
                                                 const std::string& link) {
  std::unique_ptr<PtyBase> base(new PtyBase(config, link));
  if (auto plugged = base->Plug(); !plugged) return plugged.error();
  base->thread_ = std::thread([raw = base.get()] { raw->Run(); });
  return base;
}

PtyBase::~PtyBase() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
  Unplug();
}

void PtyBase::Unplug() {
  const std::lock_guard lock(mutex_);
  slave_.Close();
  master_.Close();
  ::unlink(link_.c_str());
}

Result<Done> PtyBase::Plug() {
  const std::lock_guard lock(mutex_);
  process::FileHandle master(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!master.valid() || ::grantpt(master.get()) != 0 || ::unlockpt(master.get()) != 0) {
    return SystemError("cannot make a pseudo terminal");
  }
  std::array<char, 128> name{};
  if (::ptsname_r(master.get(), name.data(), name.size()) != 0) {
    return SystemError("cannot name the pseudo terminal");
  }
  process::FileHandle slave(::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  termios settings{};
  if (!slave.valid() || ::tcgetattr(slave.get(), &settings) != 0) {
    return SystemError("cannot open the pseudo terminal");
  }
  ::cfmakeraw(&settings);
  ::tcsetattr(slave.get(), TCSANOW, &settings);
  ::unlink(link_.c_str());
  if (::symlink(name.data(), link_.c_str()) != 0) return SystemError(link_ + ": cannot link");
  master_ = std::move(master);
  slave_ = std::move(slave);
  return Done{};
}

void PtyBase::With(const std::function<void(Emulator&)>& work) {
  const std::lock_guard lock(mutex_);
  work(emulator_);
}

void PtyBase::SendGarbage(std::vector<uint8_t> bytes) {
  const std::lock_guard lock(mutex_);
  garbage_ = std::move(bytes);
}

void PtyBase::Run() {
  while (!stop_) {
    {
      const std::lock_guard lock(mutex_);
      const Utime now = SteadyNow();
      if (master_.valid()) {
        std::array<uint8_t, 512> buffer;
        const ssize_t n = ::read(master_.get(), buffer.data(), buffer.size());
        if (n > 0) emulator_.Write(std::span(buffer.data(), static_cast<size_t>(n)), now);
      }
      for (const auto& delivery : emulator_.AdvanceTo(now)) {
        const auto& bytes = garbage_.empty() ? delivery.bytes : garbage_;
        // Bytes that a full terminal does not take are lost, as on a line without flow control.
        if (master_.valid()) (void)!::write(master_.get(), bytes.data(), bytes.size());
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace gw::kobuki

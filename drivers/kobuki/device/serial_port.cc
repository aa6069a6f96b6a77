#include "drivers/kobuki/device/serial_port.h"

#include <fcntl.h>
#include <linux/serial.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

namespace gw::kobuki {
namespace {

Error OpenError(const std::string& path, int error) {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
    case ENOTDIR:
      return {ErrorCode::kNotFound,
              path +
                  ": no such device: plug in the base's USB cable, or correct "
                  "drivers.kobuki.device"};
    case EACCES:
    case EPERM:
      return {ErrorCode::kIo, path +
                                  ": no permission: add this user to the group dialout, or "
                                  "install the udev rules"};
    case EBUSY:
    case EWOULDBLOCK:
      return {ErrorCode::kIo, path + ": in use by another program: stop it first"};
    default:
      return {ErrorCode::kIo, path + ": cannot open: " + std::strerror(error)};
  }
}

bool RequestLowLatency(int fd) {
  serial_struct serial{};
  if (::ioctl(fd, TIOCGSERIAL, &serial) != 0) return false;
  serial.flags |= ASYNC_LOW_LATENCY;
  return ::ioctl(fd, TIOCSSERIAL, &serial) == 0;
}

}  // namespace

Result<SerialPort> SerialPort::Open(const std::string& path) {
  process::FileHandle fd(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!fd.valid()) return OpenError(path, errno);
  termios settings{};
  if (::tcgetattr(fd.get(), &settings) != 0) {
    return Error{ErrorCode::kBadData, path + ": not a serial port: correct drivers.kobuki.device"};
  }
  // The lock also keeps out programs of root, which TIOCEXCL lets in.
  if (::flock(fd.get(), LOCK_EX | LOCK_NB) != 0) return OpenError(path, errno);
  (void)::ioctl(fd.get(), TIOCEXCL);
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | PARENB | CRTSCTS);
  settings.c_iflag &= ~static_cast<tcflag_t>(IXON | IXOFF | IXANY);
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  ::cfsetispeed(&settings, B115200);
  ::cfsetospeed(&settings, B115200);
  if (::tcsetattr(fd.get(), TCSANOW, &settings) != 0) return OpenError(path, errno);
  const bool low_latency = RequestLowLatency(fd.get());
  (void)::tcflush(fd.get(), TCIOFLUSH);
  return SerialPort(std::move(fd), path, low_latency);
}

Result<std::vector<uint8_t>> SerialPort::Read() {
  std::array<uint8_t, 4096> buffer;
  const ssize_t n = ::read(fd_.get(), buffer.data(), buffer.size());
  if (n > 0) return std::vector<uint8_t>(buffer.begin(), buffer.begin() + n);
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return std::vector<uint8_t>();
  // With VMIN 0, "nothing there" and "gone" both read as zero bytes; poll tells them apart.
  pollfd gone{fd_.get(), POLLIN, 0};
  if (n == 0 && ::poll(&gone, 1, 0) >= 0 && (gone.revents & (POLLHUP | POLLERR | POLLNVAL)) == 0) {
    return std::vector<uint8_t>();
  }
  return Error{ErrorCode::kIo,
               path_ + ": the device is gone: " + (n == 0 ? "hung up" : std::strerror(errno))};
}

Result<bool> SerialPort::Write(std::span<const uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd_.get(), bytes.data(), bytes.size());
    if (n > 0) {
      bytes = bytes.subspan(static_cast<size_t>(n));
    } else if (n == 0 || errno == EAGAIN) {
      return false;
    } else if (errno != EINTR) {
      return Error{ErrorCode::kIo, path_ + ": the device is gone: " + std::strerror(errno)};
    }
  }
  return true;
}

void SerialPort::Drain(int timeout_ms) {
  for (int waited_ms = 0; waited_ms < timeout_ms; waited_ms += 5) {
    int queued = 0;
    if (::ioctl(fd_.get(), TIOCOUTQ, &queued) != 0 || queued == 0) return;
    const timespec pause{0, 5'000'000};
    ::nanosleep(&pause, nullptr);
  }
}

}  // namespace gw::kobuki

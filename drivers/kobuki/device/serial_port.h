// The serial port of a Kobuki: 115200 8N1, raw, locked for this program alone.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "common/process/file_handle.h"

namespace gw::kobuki {

class SerialPort {
 public:
  // Opens without waiting and drops what was buffered. Errors, each with what to do about it:
  // kNotFound (no such device), kIo (no permission, in use, or the device failed), kBadData (not a
  // serial port). Asks the adapter for low latency (1 ms instead of 16 for FTDI); one that cannot
  // is used as it is.
  static Result<SerialPort> Open(const std::string& path);

  // The bytes that have arrived; empty when nothing has. Error kIo: the device is gone.
  Result<std::vector<uint8_t>> Read();
  // Writes as much as fits without waiting; false when some of it did not. Error kIo: the device is
  // gone.
  Result<bool> Write(std::span<const uint8_t> bytes);
  // Waits until all is sent, at most for this long.
  void Drain(int timeout_ms);

  int fd() const { return fd_.get(); }
  const std::string& path() const { return path_; }
  bool low_latency() const { return low_latency_; }

 private:
  SerialPort(process::FileHandle fd, std::string path, bool low_latency)
      : fd_(std::move(fd)), path_(std::move(path)), low_latency_(low_latency) {}

  process::FileHandle fd_;
  std::string path_;
  bool low_latency_;
};

}  // namespace gw::kobuki

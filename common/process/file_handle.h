// An open file descriptor with one owner.
#pragma once

#include <unistd.h>

#include <utility>

namespace gw::process {

class FileHandle {
 public:
  explicit FileHandle(int fd = -1) : fd_(fd) {}
  FileHandle(FileHandle&& other) noexcept : fd_(other.Release()) {}
  FileHandle& operator=(FileHandle&& other) noexcept {
    if (this != &other) {
      Close();
      fd_ = other.Release();
    }
    return *this;
  }
  ~FileHandle() { Close(); }

  int get() const { return fd_; }
  bool valid() const { return fd_ >= 0; }
  // False: errno says what went wrong; written data may be lost.
  bool Close() {
    const int fd = Release();
    return fd < 0 || ::close(fd) == 0;
  }
  int Release() { return std::exchange(fd_, -1); }

 private:
  int fd_;
};

}  // namespace gw::process

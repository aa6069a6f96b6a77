// The system calls that the driver makes on video nodes, so that tests can stand in for the kernel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace gw::camera {

class SystemCalls {
 public:
  virtual ~SystemCalls() = default;
  // Opens for reading and writing, non-blocking and close-on-exec. Gives a descriptor that poll(2)
  // takes, or -errno.
  virtual int Open(const std::string& path) = 0;
  virtual void Close(int fd) = 0;
  // Gives 0 or -errno; a call that a signal interrupts is tried again.
  virtual int Ioctl(int fd, uint64_t request, void* argument) = 0;
  // Maps a buffer of the device. Null when that failed.
  virtual uint8_t* Map(int fd, size_t length, int64_t offset) = 0;
  virtual void Unmap(uint8_t* memory, size_t length) = 0;
  // The pause before a control that the device refused for the moment is tried again.
  virtual void Pause() = 0;
};

// The calls of the kernel itself.
SystemCalls& RealSystemCalls();

}  // namespace gw::camera

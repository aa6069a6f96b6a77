#include "drivers/camera/device/system_calls.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>

namespace gw::camera {
namespace {

class Kernel : public SystemCalls {
 public:
  int Open(const std::string& path) override {
    const int fd = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    return fd >= 0 ? fd : -errno;
  }
  void Close(int fd) override { ::close(fd); }
  int Ioctl(int fd, uint64_t request, void* argument) override {
    int result = 0;
    do {
      result = ::ioctl(fd, request, argument);
    } while (result < 0 && errno == EINTR);
    return result < 0 ? -errno : 0;
  }
  uint8_t* Map(int fd, size_t length, int64_t offset) override {
    void* memory = ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, fd, offset);
    return memory == MAP_FAILED ? nullptr : static_cast<uint8_t*>(memory);
  }
  void Unmap(uint8_t* memory, size_t length) override { ::munmap(memory, length); }
  void Pause() override {
    const timespec pause{0, 10'000'000};
    ::nanosleep(&pause, nullptr);
  }
};

}  // namespace

SystemCalls& RealSystemCalls() {
  static Kernel kernel;
  return kernel;
}

}  // namespace gw::camera

#include "drivers/camera/device/sysfs.h"

#include <fcntl.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>

#include "common/process/file_handle.h"

namespace gw::camera {

std::string ReadSysfs(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

int ReadSysfsNumber(const std::filesystem::path& file, int base) {
  const std::string text = ReadSysfs(file);
  int value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value, base);
  return value;
}

Result<Done> WriteSysfs(const std::filesystem::path& file, const std::string& value) {
  // The kernel answers the write and not the close, so that no buffered stream is used.
  const process::FileHandle handle(::open(file.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC));
  const bool written = handle.valid() && ::write(handle.get(), value.data(), value.size()) ==
                                             static_cast<ssize_t>(value.size());
  if (written) return Done{};
  const int error = errno;
  const bool permission = error == EACCES || error == EPERM;
  return Error{ErrorCode::kIo, file.string() + ": cannot write " + value + ": " +
                                   std::strerror(error) +
                                   (permission ? ": install the udev rules" : "")};
}

}  // namespace gw::camera

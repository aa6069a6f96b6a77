#include "grid/files/whole_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

#include "common/process/file_handle.h"

namespace gw::grid {
namespace {

Error IoError(const std::string& path, const std::string& what, int number) {
  return {ErrorCode::kIo, path + ": " + what + ": " + std::generic_category().message(number)};
}

}  // namespace

Result<Done> WriteWholeFile(const std::string& path, std::span<const uint8_t> bytes) {
  const std::string part = path + ".part";
  {
    const process::FileHandle file(
        ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (file.get() < 0) return IoError(path, "cannot be written", errno);
    while (!bytes.empty()) {
      const ssize_t written = ::write(file.get(), bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return IoError(path, "cannot be written, check free space", errno);
      bytes = bytes.subspan(static_cast<size_t>(written));
    }
    if (::fsync(file.get()) != 0) return IoError(path, "cannot be written", errno);
  }
  if (std::rename(part.c_str(), path.c_str()) != 0) {
    return IoError(path, "cannot be replaced", errno);
  }
  return Done{};
}

Result<std::vector<uint8_t>> ReadWholeFile(const std::string& path) {
  if (!std::filesystem::exists(path)) {
    return Error{ErrorCode::kNotFound, path + ": no such file"};
  }
  std::ifstream file(path, std::ios::binary);
  std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file.good() && !file.eof()) return IoError(path, "cannot be read", errno);
  return bytes;
}

}  // namespace gw::grid

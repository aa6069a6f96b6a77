#include "tools/data/files/hash_file.h"

#include <fmt/format.h>

#include <fstream>
#include <vector>

#include "common/core/hash.h"

namespace gw::tools {

Result<uint64_t> HashFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::kNotFound, path + ": cannot be opened"};
  std::vector<char> buffer(size_t{1} << 20);
  uint64_t hash = kFnvOffset;
  while (file) {
    file.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    hash = Fnv1a({buffer.data(), static_cast<size_t>(file.gcount())}, hash);
  }
  if (!file.eof()) return Error{ErrorCode::kIo, path + ": cannot be read"};
  return hash;
}

std::string HashText(uint64_t hash) {
  return fmt::format("{:016x}", hash);
}

}  // namespace gw::tools

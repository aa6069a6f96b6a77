#include "tools/data/files/hash_file.h"

#include <array>
#include <cinttypes>
#include <cstdio>
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
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016" PRIx64, hash);
  return text.data();
}

}  // namespace gw::tools

// A file's bytes without reading it all into memory.
#pragma once

#include <filesystem>
#include <memory>

#include "common/core/result.h"
#include "tools/data/bag/byte_cursor.h"

namespace gw::bag {

class MappedFile {
 public:
  // Error: kNotFound, kIo.
  static Result<std::unique_ptr<MappedFile>> Open(const std::filesystem::path& file);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  Bytes bytes() const { return bytes_; }

 private:
  explicit MappedFile(Bytes bytes) : bytes_(bytes) {}
  Bytes bytes_;
};

}  // namespace gw::bag

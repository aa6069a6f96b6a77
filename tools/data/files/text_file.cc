#include "tools/data/files/text_file.h"

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

namespace gw::tools {

Result<std::string> ReadTextFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return Error{ErrorCode::kNotFound,
                 path + ": cannot open: " + std::generic_category().message(errno)};
  }
  std::ostringstream text;
  if (file.peek() != std::ifstream::traits_type::eof()) text << file.rdbuf();
  if (file.bad() || text.fail()) return Error{ErrorCode::kIo, path + ": cannot read"};
  return text.str();
}

Result<Done> WriteTextFile(const std::string& path, const std::string& text) {
  const std::string part = path + ".part";
  const auto fail = [&](const std::string& reason) {
    return Error{ErrorCode::kIo,
                 path + ": cannot be written: " + reason + "; check permissions and free space"};
  };
  std::ofstream file(part, std::ios::binary);
  file << text;
  file.close();
  if (!file) return fail(std::generic_category().message(errno));
  std::error_code error;
  std::filesystem::rename(part, path, error);
  if (error) return fail(error.message());
  return Done{};
}

}  // namespace gw::tools

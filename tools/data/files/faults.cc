#include "tools/data/files/faults.h"

#include <algorithm>
#include <sstream>

namespace gw::tools {

void Faults::Add(const Error& error) {
  if (!first_code_) first_code_ = error.code;
  std::istringstream text(error.message);
  for (std::string line; std::getline(text, line);) {
    if (std::find(lines_.begin(), lines_.end(), line) != lines_.end()) continue;
    if (lines_.size() < kMostLines) {
      lines_.push_back(line);
    } else {
      ++more_;
    }
  }
}

Error Faults::error() const {
  std::string text;
  for (const std::string& line : lines_) text += (text.empty() ? "" : "\n") + line;
  if (more_ > 0) text += "\nand " + std::to_string(more_) + " more";
  return {*first_code_, text};
}

Result<Done> Faults::Verdict() const {
  if (empty()) return Done{};
  return error();
}

}  // namespace gw::tools

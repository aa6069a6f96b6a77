#include "common/process/log_line.h"

#include <algorithm>
#include <cstdio>

namespace gw::process {
namespace {

// Quoted where the value is not one plain word, so that the line can be taken apart again.
std::string Value(const std::string& text) {
  const bool plain = !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return c > ' ' && c < 0x7F && c != '"' && c != '=' && c != '\\';
  });
  if (plain) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += static_cast<unsigned char>(c) < ' ' ? ' ' : c;  // a line stays one line
  }
  return quoted + '"';
}

}  // namespace

void LogLine::Write(Utime now, Severity severity, const std::string& event,
                    std::initializer_list<Field> fields) {
  const auto [past, first] = past_.try_emplace(event, Past{now, 0});
  if (!first && now - past->second.written < min_interval_ && now >= past->second.written) {
    ++past->second.suppressed;
    return;
  }
  std::string line = "<" + std::to_string(static_cast<int>(severity)) + ">event=" + Value(event);
  for (const auto& [key, value] : fields) {
    line += ' ';
    line += key;
    line += '=' + Value(value);
  }
  if (past->second.suppressed > 0) {
    line += " suppressed=" + std::to_string(past->second.suppressed);
  }
  past->second = {now, 0};
  sink_(line + '\n');
}

void LogLine::WriteToStderr(const std::string& line) {
  std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace gw::process

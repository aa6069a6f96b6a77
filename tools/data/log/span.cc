#include "tools/data/log/span.h"

#include <charconv>
#include <optional>

namespace gw::tools {
namespace {

std::vector<std::string> Split(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ':') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

std::optional<double> ParseNumber(const std::string& text) {
  double value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if (!(value >= 0 && value < 1e9)) return std::nullopt;
  return value;
}

}  // namespace

Result<SpanArgument> ParseSpan(const std::string& option, const std::string& text,
                               size_t min_values, size_t max_values) {
  const auto fail = [&](const std::string& rule) {
    return Error{ErrorCode::kInvalidArgument, option + " " + text + ": " + rule};
  };
  const std::vector<std::string> parts = Split(text);
  if (parts.size() < 2 + min_values || parts.size() > 2 + max_values) {
    return fail("expected T0:T1" + std::string(max_values > 0 ? " and its values" : "") +
                ", separated by colons, in seconds from the begin of the log");
  }
  SpanArgument out;
  for (size_t i = 0; i < parts.size(); ++i) {
    if (i < 2 && parts[i].empty()) continue;
    const std::optional<double> value = ParseNumber(parts[i]);
    if (!value) return fail("'" + parts[i] + "' is no number from 0 to 1e9");
    if (i == 0) {
      out.span.begin = DurationFromSeconds(*value);
    } else if (i == 1) {
      out.span.end = DurationFromSeconds(*value);
    } else {
      out.values.push_back(*value);
    }
  }
  if (out.span.end <= out.span.begin) return fail("the end must lie behind the begin");
  return out;
}

}  // namespace gw::tools

#include "tools/data/files/format.h"

#include <fmt/args.h>
#include <fmt/printf.h>

namespace gw::tools {

std::string FormatValues(const char* format, std::initializer_list<FormatValue> values) {
  fmt::dynamic_format_arg_store<fmt::printf_context> arguments;
  for (const FormatValue& value : values) {
    std::visit([&](const auto& v) { arguments.push_back(v); }, value);
  }
  return fmt::vsprintf(format, fmt::basic_format_args<fmt::printf_context>(arguments));
}

std::string TumLine(Utime utime, const SE3& T) {
  const Eigen::Vector3d& p = T.translation();
  const Eigen::Quaterniond& q = T.rotation();
  return Format("%.6f %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n", utime.seconds(), p.x(), p.y(), p.z(),
                q.x(), q.y(), q.z(), q.w());
}

}  // namespace gw::tools

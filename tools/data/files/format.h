// printf into strings.
#pragma once

#include <cstdio>
#include <string>

#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw::tools {

// `format` and values as of printf; any length.
template <typename... Values>
std::string Format(const char* format, Values... values) {
  const int length = std::snprintf(nullptr, 0, format, values...);
  std::string text(static_cast<size_t>(length), '\0');
  std::snprintf(text.data(), text.size() + 1, format, values...);
  return text;
}

// A line of a trajectory file: t tx ty tz qx qy qz qw; s, m.
inline std::string TumLine(Utime utime, const SE3& T) {
  const Eigen::Vector3d& p = T.translation();
  const Eigen::Quaterniond& q = T.rotation();
  return Format("%.6f %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n", utime.seconds(), p.x(), p.y(), p.z(),
                q.x(), q.y(), q.z(), q.w());
}

}  // namespace gw::tools

// Text from values, by the format strings of printf; types are taken from the values.
#pragma once

#include <fmt/printf.h>

#include <string>

#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw::tools {

template <typename... Values>
std::string Format(const char* format, const Values&... values) {
  return fmt::sprintf(format, values...);
}

// A line of a trajectory file: t tx ty tz qx qy qz qw; s, m.
inline std::string TumLine(Utime utime, const SE3& T) {
  const Eigen::Vector3d& p = T.translation();
  const Eigen::Quaterniond& q = T.rotation();
  return Format("%.6f %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n", utime.seconds(), p.x(), p.y(), p.z(),
                q.x(), q.y(), q.z(), q.w());
}

}  // namespace gw::tools

// When two poses look the same way from about the same place.
#pragma once

#include <numbers>

#include "common/core/se3.h"

namespace gw::study {

inline double AngleDeg(const SE3& T) {
  return LogSO3(T.rotation()).norm() * 180 / std::numbers::pi;
}

inline bool SameView(const SE3& a, const SE3& b, double distance_m, double angle_deg) {
  const SE3 T_ab = a.inverse() * b;
  return T_ab.translation().norm() < distance_m && AngleDeg(T_ab) < angle_deg;
}

}  // namespace gw::study

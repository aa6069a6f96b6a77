#include "drivers/camera/protocol/motion_units.h"

#include <numbers>

namespace gw::camera {
namespace {

constexpr double kStandardGravity = 9.80665;
constexpr double kRadPerDeg = std::numbers::pi / 180;
constexpr FirmwareVersion kFineGyro{5, 16, 0, 0};

Eigen::Vector3d InCameraAxes(const Eigen::Vector3d& sensor) {
  return {-sensor.x(), sensor.y(), -sensor.z()};
}

}  // namespace

Eigen::Vector3d GyroFromRaw(const std::array<int64_t, 3>& raw, const FirmwareVersion& firmware) {
  Eigen::Vector3d deg_s;
  for (int i = 0; i < 3; ++i) {
    const int64_t value = raw[static_cast<size_t>(i)];
    deg_s[i] = firmware < kFineGyro ? 0.1 * static_cast<int16_t>(value & 0xFFFF)
                                    : 1e-4 * static_cast<double>(value);
  }
  return InCameraAxes(deg_s * kRadPerDeg);
}

Eigen::Vector3d AccelFromRaw(const std::array<int64_t, 3>& raw) {
  return InCameraAxes(Eigen::Vector3d(static_cast<double>(raw[0]), static_cast<double>(raw[1]),
                                      static_cast<double>(raw[2])) *
                      (1e-3 * kStandardGravity));
}

std::optional<int> SamplingFrequencyCode(int rate_hz) {
  switch (rate_hz) {
    case 63:
    case 100:
      return 1;
    case 200:
      return 2;
    case 250:
      return 3;
    case 400:
      return 4;
    default:
      return std::nullopt;
  }
}

}  // namespace gw::camera

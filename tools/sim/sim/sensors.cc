#include "tools/sim/sim/sensors.h"

#include <cmath>
#include <numbers>

#include "common/core/random.h"
#include "tools/sim/sim/part_tolerance.h"
#include "tools/sim/sim/smooth_noise.h"

namespace gw::sim {
namespace {

constexpr double kGravity = 9.80665;  // m/s^2
constexpr double kShakeTime =
    0.025;                           // s: a robot on its tyres and its bracket swing at 10 to 30 Hz
constexpr double kShakeSpeed = 0.5;  // m/s
// RMS of the slope of SmoothNoise of length 1: the mean square of the slope of its fade, 10/7,
// times that of the difference of two values, 2, times its norm.
constexpr double kSlopeOfSmoothNoise = 1.99;

Eigen::Vector3d Normal3(CounterRng* rng) {
  const double x = rng->Normal(), y = rng->Normal(), z = rng->Normal();
  return {x, y, z};
}

}  // namespace

ImuSensor::ImuSensor(const ImuConfig& config, const SE3& T_BI, uint64_t seed)
    : config_(config), T_BI_(T_BI), seed_(seed) {
  CounterRng rng(seed, 0x1B1A5, 0);
  gyro_bias_ = config.gyro_bias * Normal3(&rng);
  accel_bias_ = config.accel_bias * Normal3(&rng);
  for (int i = 0; i < 3; ++i) gyro_scale_[i] = 1 + DrawError(&rng, config.gyro_scale_error);
}

// The sum of the shaking stays small however long it lasts: what swings comes back.
ImuSensor::Shake ImuSensor::ShakeAt(Utime t, double speed) const {
  const double share = speed / kShakeSpeed * kShakeTime / kSlopeOfSmoothNoise;
  Shake shake;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<uint64_t>(i);
    shake.turn[i] =
        config_.shake_rad_s * share * SmoothNoise(seed_, 0x5A4E + axis, kShakeTime).At(t.seconds());
    shake.velocity[i] =
        config_.shake_m_s2 * share * SmoothNoise(seed_, 0x5A5E + axis, kShakeTime).At(t.seconds());
  }
  return shake;
}

ImuSample ImuSensor::Measure(Utime end, double dt, const SE3& T_GB, const Eigen::Vector3d& v_GI,
                             double speed) {
  const Eigen::Quaterniond q_GI = T_GB.rotation() * T_BI_.rotation();
  if (first_) {
    q_GI_before_ = q_GI;
    v_before_ = v_GI;
    first_ = false;
  }
  CounterRng rng(seed_, 0x1A1A, static_cast<uint64_t>(seq_));
  // A density d gives samples of sigma d / sqrt(dt); a walk w gives steps of sigma w sqrt(dt).
  gyro_bias_ += config_.gyro_walk * std::sqrt(dt) * Normal3(&rng);
  accel_bias_ += config_.accel_walk * std::sqrt(dt) * Normal3(&rng);
  ImuSample sample;
  sample.utime = end - DurationFromSeconds(dt / 2);
  sample.seq = seq_++;
  const Shake shake = ShakeAt(end, speed);
  const Eigen::Vector3d turn =
      LogSO3(q_GI_before_.conjugate() * q_GI) + shake.turn - shake_before_.turn;
  sample.w_I_rad_s = gyro_scale_.cwiseProduct(turn) / dt + gyro_bias_ +
                     config_.gyro_noise / std::sqrt(dt) * Normal3(&rng);
  const Eigen::Vector3d a_G = (v_GI - v_before_) / dt + Eigen::Vector3d(0, 0, kGravity);
  const Eigen::Quaterniond q_middle = q_GI_before_ * ExpSO3(0.5 * turn);
  sample.a_I_m_s2 = q_middle.conjugate() * a_G + (shake.velocity - shake_before_.velocity) / dt +
                    accel_bias_ + config_.accel_noise / std::sqrt(dt) * Normal3(&rng);
  sample.has_accel = true;
  q_GI_before_ = q_GI;
  v_before_ = v_GI;
  shake_before_ = shake;
  return sample;
}

WheelSensor::WheelSensor(double track_m, double ticks_per_metre, uint64_t seed)
    : track_m_(track_m), ticks_per_metre_(ticks_per_metre), seed_(seed) {
  CounterRng rng(seed, 0x6E40, 0);
  // Kobuki documentation: 0.47 deg after half a square, some degrees after several.
  gyro_scale_ = 1 + 0.003 * rng.Normal();
  gyro_drift_rad_s_ = 0.0003 * rng.Normal();
}

WheelSample WheelSensor::Measure(Utime now, double left_way, double right_way, double yaw,
                                 bool bumper) {
  const int64_t left = static_cast<int64_t>(std::floor(left_way * ticks_per_metre_));
  const int64_t right = static_cast<int64_t>(std::floor(right_way * ticks_per_metre_));
  WheelSample sample;
  const bool first = seq_ == 0;
  if (first) {
    left_before_ = left;
    right_before_ = right;
    before_ = now - Milliseconds(20);
    yaw_before_ = yaw;
  }
  sample.utime = now;
  sample.utime_begin = before_;
  sample.has_ticks = true;
  sample.left_ticks = static_cast<uint16_t>(left & 0xFFFF);
  sample.right_ticks = static_cast<uint16_t>(right & 0xFFFF);
  const double left_m = static_cast<double>(left - left_before_) / ticks_per_metre_;
  const double right_m = static_cast<double>(right - right_before_) / ticks_per_metre_;
  sample.dyaw_rad = (right_m - left_m) / track_m_;
  const double way = 0.5 * (left_m + right_m);
  // An arc counts as its chord, seen from its begin.
  const double half = 0.5 * sample.dyaw_rad;
  const double chord = std::abs(half) < 1e-6 ? way : way * std::sin(half) / half;
  sample.dx_m = chord * std::cos(half);
  sample.dy_m = chord * std::sin(half);
  const double dt = (now - before_).seconds();
  CounterRng rng(seed_, 0x6E41, static_cast<uint64_t>(seq_));
  heading_ = std::remainder(
      heading_ + gyro_scale_ * std::remainder(yaw - yaw_before_, 2 * std::numbers::pi) +
          gyro_drift_rad_s_ * dt + 1e-4 * rng.Normal(),
      2 * std::numbers::pi);
  constexpr double kUnit = 0.01 * std::numbers::pi / 180;  // of the packet
  sample.has_heading = true;
  sample.heading_rad = std::remainder(std::round(heading_ / kUnit) * kUnit, 2 * std::numbers::pi);
  sample.contact.bumper = bumper;
  sample.seq = seq_++;
  left_before_ = left;
  right_before_ = right;
  yaw_before_ = yaw;
  before_ = now;
  return sample;
}

}  // namespace gw::sim

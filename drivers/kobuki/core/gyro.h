// The raw three-axis gyro (L3G4200D at +-250 deg/s): axes, scale, sample times and bias.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "drivers/common/lower_envelope.h"
#include "drivers/kobuki/protocol/feedback.h"

namespace gw::kobuki {

inline constexpr double kGyroRadPerLsb = 0.00875 * std::numbers::pi / 180;

// The rate in B, rad/s, with its bias. The sensor sits turned by 90 degrees counter-clockwise about
// z.
inline Eigen::Vector3d GyroRate(const std::array<int16_t, 3>& raw) {
  return kGyroRadPerLsb * Eigen::Vector3d(-raw[1], raw[0], raw[2]);
}

// Tells when each sample was taken, in robot time. Samples carry a running number but no time: they
// are taken at a steady rate of nominally 100 Hz (104 Hz was measured on one robot), and each is
// older than the frame that brings it. The envelope under the ages finds rate and phase.
class GyroTiming {
 public:
  struct Times {
    size_t first_new = 0;           // index of the first sample that has not come before
    std::vector<int64_t> robot_us;  // times of all samples of the frame
  };

  // `robot_us` is the time of the frame; it must not decrease between resets.
  Times Stamp(const RawGyro& gyro, int64_t robot_us);
  void Reset();

  int64_t lost() const { return lost_; }  // samples that never came

  static constexpr int64_t kNominalPeriodUs = 10'000;

 private:
  // The rate is within 6 % of nominal.
  LowerEnvelope age_{{.bin = 250'000, .num_bins = 120, .max_slope = 0.06}};
  std::optional<uint8_t> next_id_;
  int64_t next_index_ = 0;
  int64_t last_frame_us_ = 0;
  int64_t lost_ = 0;
};

// The mean of the gyro while the base stands still, which is the bias to be taken off. Only whole
// windows of standing count, and only once the base stood still for some time after them: motion
// begins in the gyro before the wheels show it.
class StationaryBias {
 public:
  // `stationary` says that the wheels neither turn nor are driven.
  void Add(const Eigen::Vector3d& w_B_rad_s, bool stationary);

  bool known() const { return windows_ > 0; }
  const Eigen::Vector3d& bias_rad_s() const { return bias_; }
  int64_t windows() const { return windows_; }

  static constexpr int kWindow = 100;  // samples, about one second
  static constexpr int kAfter = 20;
  // Beyond these limits someone turns or shakes the base by hand (noise of the sensor: 0.1 deg/s).
  static constexpr double kMaxBias = 5 * std::numbers::pi / 180;
  static constexpr double kMaxSigma = 0.5 * std::numbers::pi / 180;
  static constexpr double kGain = 0.2;  // weight of each window after the first

 private:
  void StartWindow();

  int count_ = 0;
  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d sum_squares_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
  int64_t windows_ = 0;
};

}  // namespace gw::kobuki

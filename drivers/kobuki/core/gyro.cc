#include "drivers/kobuki/core/gyro.h"

#include <algorithm>
#include <cmath>

namespace gw::kobuki {

GyroTiming::Times GyroTiming::Stamp(const RawGyro& gyro, int64_t robot_us) {
  // After a gap of half a turn of the running number it is not known how many samples are missing.
  if (next_id_ && robot_us - last_frame_us_ > 128 * kNominalPeriodUs) Reset();
  const int step =
      next_id_ ? static_cast<int8_t>(static_cast<uint8_t>(gyro.first_id - *next_id_)) : 0;
  const int num_samples = static_cast<int>(gyro.samples.size());
  Times out;
  if (step < 0) {
    out.first_new = static_cast<size_t>(std::min(-step, num_samples));
  } else {
    lost_ += step;
  }
  const int64_t first_index = next_index_ + step;
  const int64_t newest = first_index + num_samples - 1;
  if (newest >= next_index_) {
    const int64_t nominal = newest * kNominalPeriodUs;
    age_.Add(nominal, robot_us - nominal);
    next_index_ = newest + 1;
    next_id_ = static_cast<uint8_t>(gyro.first_id + num_samples);
    last_frame_us_ = robot_us;
  }
  for (int64_t i = first_index; i <= newest; ++i) {
    const int64_t nominal = i * kNominalPeriodUs;
    out.robot_us.push_back(nominal + std::llround(age_.At(nominal)));
  }
  return out;
}

void GyroTiming::Reset() {
  age_.Clear();
  next_id_.reset();
}

void StationaryBias::StartWindow() {
  count_ = 0;
  sum_.setZero();
  sum_squares_.setZero();
}

void StationaryBias::Add(const Eigen::Vector3d& w_B_rad_s, bool stationary) {
  if (!stationary) return StartWindow();
  if (++count_ <= kWindow) {
    sum_ += w_B_rad_s;
    sum_squares_ += w_B_rad_s.cwiseAbs2();
  }
  if (count_ < kWindow + kAfter) return;
  const Eigen::Vector3d mean = sum_ / kWindow;
  const Eigen::Vector3d variance = sum_squares_ / kWindow - mean.cwiseAbs2();
  StartWindow();
  if (mean.cwiseAbs().maxCoeff() > kMaxBias) return;
  if (variance.maxCoeff() > kMaxSigma * kMaxSigma) return;
  bias_ += (windows_ == 0 ? 1.0 : kGain) * (mean - bias_);
  ++windows_;
}

}  // namespace gw::kobuki

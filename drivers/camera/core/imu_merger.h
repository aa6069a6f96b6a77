// Makes one IMU out of two sensors with rates of their own: every gyro sample goes out with the
// accelerometer interpolated to its time.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <vector>

#include "common/contract/samples.h"

namespace gw::camera {

struct TimedVector {
  Utime utime;
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
};

class ImuMerger {
 public:
  // Each call gives the samples that are complete now; their utime strictly increases and their seq
  // counts from 1. A sample that is not after the one before of its sensor is dropped.
  std::vector<ImuSample> AddGyro(const TimedVector& w_I_rad_s);
  std::vector<ImuSample> AddAccel(const TimedVector& a_I_m_s2);

  int64_t dropped() const { return dropped_; }  // samples that came out of order
  int64_t without_accel() const { return without_accel_; }

  // A gyro sample waits for the accelerometer for this long (its slowest rate is 63 Hz), then goes
  // without it.
  static constexpr DurationUs kMaxWait = Milliseconds(60);

 private:
  bool Accept(const TimedVector& sample, std::deque<TimedVector>* queue);
  std::vector<ImuSample> TakeComplete();

  std::deque<TimedVector> gyro_, accel_;
  Utime last_gyro_{INT64_MIN};
  int64_t seq_ = 0;
  int64_t dropped_ = 0;
  int64_t without_accel_ = 0;
};

}  // namespace gw::camera

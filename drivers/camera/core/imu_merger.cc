#include "drivers/camera/core/imu_merger.h"

namespace gw::camera {

bool ImuMerger::Accept(const TimedVector& sample, std::deque<TimedVector>* queue) {
  if (!queue->empty() && sample.utime <= queue->back().utime) {
    ++dropped_;
    return false;
  }
  queue->push_back(sample);
  return true;
}

std::vector<ImuSample> ImuMerger::AddGyro(const TimedVector& w_I_rad_s) {
  if (w_I_rad_s.utime <= last_gyro_) {
    ++dropped_;
    return {};
  }
  last_gyro_ = w_I_rad_s.utime;
  gyro_.push_back(w_I_rad_s);
  return TakeComplete();
}

std::vector<ImuSample> ImuMerger::AddAccel(const TimedVector& a_I_m_s2) {
  if (!Accept(a_I_m_s2, &accel_)) return {};
  return TakeComplete();
}

std::vector<ImuSample> ImuMerger::TakeComplete() {
  std::vector<ImuSample> out;
  while (!gyro_.empty()) {
    const TimedVector& gyro = gyro_.front();
    // Only the last accelerometer sample before the gyro's and those after it matter.
    while (accel_.size() >= 2 && accel_[1].utime <= gyro.utime) accel_.pop_front();
    const bool bracketed =
        accel_.size() >= 2 && accel_[0].utime <= gyro.utime && gyro.utime < accel_[1].utime;
    const bool too_late = !accel_.empty() && accel_[0].utime > gyro.utime;
    const bool waited = gyro_.back().utime - gyro.utime > kMaxWait;
    if (!bracketed && !too_late && !waited) break;
    ImuSample sample;
    sample.utime = gyro.utime;
    sample.seq = ++seq_;
    sample.w_I_rad_s = gyro.value;
    sample.has_accel = bracketed;
    if (bracketed) {
      const double span = (accel_[1].utime - accel_[0].utime).seconds();
      const double share = (gyro.utime - accel_[0].utime).seconds() / span;
      sample.a_I_m_s2 = (1 - share) * accel_[0].value + share * accel_[1].value;
    } else {
      ++without_accel_;
    }
    out.push_back(sample);
    gyro_.pop_front();
  }
  return out;
}

}  // namespace gw::camera

#include "tools/data/fault/wheel_resampler.h"

#include <algorithm>
#include <cmath>

namespace gw::fault {
namespace {

SE3 Increment(const WheelSample& sample) {
  return SE3(ExpSO3({0, 0, sample.dyaw_rad}), {sample.dx_m, sample.dy_m, 0});
}

double Share(const WheelSample& sample, Utime utime) {
  const double length = (sample.utime - sample.utime_begin).seconds();
  return length > 0 ? std::clamp((utime - sample.utime_begin).seconds() / length, 0.0, 1.0) : 1;
}

}  // namespace

WheelResampler::Count WheelResampler::Between(const WheelSample& sample, Utime utime) const {
  const double share = Share(sample, utime);
  Count out = last_;
  out.utime = utime;
  out.T_OB = last_.T_OB * Interpolate(SE3(), Increment(sample), share);
  // Counters wrap at 65536, the heading at half a turn.
  out.left += share * static_cast<int16_t>(sample.left_ticks - previous_.left_ticks);
  out.right += share * static_cast<int16_t>(sample.right_ticks - previous_.right_ticks);
  out.heading_rad += share * std::remainder(sample.heading_rad - previous_.heading_rad, 2 * M_PI);
  return out;
}

WheelSample WheelResampler::Sum(const WheelSample& sample, const Count& end, Utime stamp) const {
  WheelSample out = sample;
  out.utime = stamp;
  out.utime_begin = stamp - period_;
  out.seq = first_seq_ + sums_;
  const SE3 T = given_.T_OB.inverse() * end.T_OB;
  out.dx_m = T.translation().x();
  out.dy_m = T.translation().y();
  out.dyaw_rad = LogSO3(T.rotation()).z();
  out.left_ticks = static_cast<uint16_t>(first_.left_ticks + std::llround(end.left));
  out.right_ticks = static_cast<uint16_t>(first_.right_ticks + std::llround(end.right));
  out.heading_rad = std::remainder(first_.heading_rad + end.heading_rad, 2 * M_PI);
  return out;
}

std::vector<WheelSample> WheelResampler::Push(const WheelSample& sample) {
  if (!begin_) {
    begin_ = sample.utime;
    first_seq_ = sample.seq;
    first_ = previous_ = sample;
    last_.utime = given_.utime = sample.utime;
    return {};
  }
  while (true) {
    const Utime stamp = *begin_ + DurationUs{(sums_ + 1) * period_.us};
    const Utime end = sums_ % 2 == 0 ? stamp - short_of_even_ : stamp;
    if (end > sample.utime) break;
    const Count count = Between(sample, end);
    made_.push_back(Sum(sample, count, stamp));
    given_ = count;
    ++sums_;
  }
  last_ = Between(sample, sample.utime);
  previous_ = sample;
  std::vector<WheelSample> out;
  while (!made_.empty() && made_.front().utime <= sample.utime) {
    out.push_back(made_.front());
    made_.pop_front();
  }
  return out;
}

}  // namespace gw::fault

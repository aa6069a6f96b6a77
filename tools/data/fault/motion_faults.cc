#include "tools/data/fault/motion_faults.h"

#include <cmath>

namespace gw::fault {

uint16_t WheelFaults::Encoder::Step(uint16_t ticks, double factor) {
  const auto way = static_cast<int16_t>(ticks - last);  // counters wrap at 65536
  last = ticks;
  offset += (factor - 1) * way;
  return static_cast<uint16_t>(ticks + static_cast<int64_t>(std::lround(offset)));
}

WheelSample WheelFaults::Apply(const WheelSample& sample, double slip_factor, bool cut) {
  WheelSample out = sample;
  const double factor = cut ? 0 : slip_factor;
  out.dx_m *= factor;
  out.dy_m *= factor;
  out.dyaw_rad *= factor;
  if (sample.has_ticks) {
    if (!last_ || !last_->has_ticks) {
      left_.last = sample.left_ticks;
      right_.last = sample.right_ticks;
    }
    out.left_ticks = left_.Step(sample.left_ticks, factor);
    out.right_ticks = right_.Step(sample.right_ticks, factor);
  }
  if (sample.has_heading) {
    if (cut && last_ && last_->has_heading) {
      heading_offset_rad_ -= sample.heading_rad - last_->heading_rad;
    }
    if (heading_offset_rad_ != 0) {
      out.heading_rad = std::remainder(sample.heading_rad + heading_offset_rad_, 2 * M_PI);
    }
  }
  last_ = sample;
  return out;
}

DrState DrFaults::Apply(const DrState& state, double slip_factor, bool cut) {
  DrState out = state;
  const bool continues = last_ && last_->reset_counter == state.reset_counter;
  if (!continues) {
    T_OB_out_ = state.T_OB;
    edited_ = false;
  } else {
    edited_ |= cut || slip_factor != 1;
    if (!edited_) {
      T_OB_out_ = state.T_OB;
    } else if (!cut) {
      const SE3 T_BaBb = last_->T_OB.inverse() * state.T_OB;
      T_OB_out_ = T_OB_out_ * SE3(T_BaBb.rotation(), T_BaBb.translation() * slip_factor);
    }
  }
  out.T_OB = T_OB_out_;
  out.v_OB_B *= slip_factor;
  last_ = state;
  return out;
}

}  // namespace gw::fault

// How far and how much a robot moved by dead reckoning, by its wheels' own sum and by its gyro:
// three answers to the same question, over the same time.
#pragma once

#include <optional>
#include <vector>

#include "tools/lab/slam/dr_only.h"

namespace gw::tools {

// The wheels' own sum, T_OB at the end of each sample (identity at the first begin), in camera
// time: every increment composed as it was measured, without any correction. A sample that begins
// elsewhere than where the one before ended (lost in between) is composed all the same and counted.
struct WheelSum {
  struct Stamped {
    Utime utime;
    SE3 T_OB;
  };
  std::vector<Stamped> poses;
  int64_t gaps = 0;
};
WheelSum SumWheels(const std::vector<WheelSample>& wheels, DurationUs wheel_offset);

// The robot stands by its wheels: samples [first, last] of the log neither turn nor move them.
struct Standstill {
  size_t first = 0, last = 0;
  double gyro_z_rad_s = 0;  // mean of the gyro about the body's z: its bias
};

// The turn by the gyro alone, its bias that of the standstills (linear between two, constant before
// the first and after the last), over the intervals that gyro and dead reckoning cover; and what
// the others say of the same intervals. rad, counter-clockwise, not wrapped.
struct GyroWitness {
  double turn_rad = 0;
  double dr_turn_rad = 0;
  double wheel_turn_rad = 0;
  double wheel_turned_rad = 0;  // sum of the sizes of the wheels' turns
  std::vector<Standstill> standstills;
};

// Motion over all wheel intervals that dead reckoning covers without a reset; without wheels, over
// all of its states. Way: sum of the lengths of the intervals' translations, m. Turn: sum of
// their yaw, rad, counter-clockwise, not wrapped.
struct DrMotion {
  double way_m = 0;
  double turn_rad = 0;
  double height_min_m = 0, height_max_m = 0;  // of T_OB, against the first state
  double tilt_max_rad = 0;                    // largest angle between z of B and z of O
  std::optional<double> wheel_way_m, wheel_turn_rad;
  std::optional<GyroWitness> gyro;  // needs wheels: they tell the standstills
  DurationUs covered;               // of the wheel intervals: by dead reckoning
  DurationUs uncovered;             // the rest of them
};
DrMotion MeasureMotion(const DrOnlyRun& run, const Calibration& calibration);

// Spans of time in which the filter flags slip.
struct SlipSpan {
  Utime begin, end;
};
std::vector<SlipSpan> SlipSpans(const std::vector<DrPose>& poses);

}  // namespace gw::tools

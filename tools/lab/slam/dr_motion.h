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

// The robot stands by its wheels: no sample of the time turns or moves them.
struct Standstill {
  Utime begin, end;         // camera time
  double gyro_z_rad_s = 0;  // mean of the gyro about the body's z: its bias
};

// Motion over all wheel intervals that dead reckoning covers without a reset; without wheels, over
// all of its states. Way: sum of the lengths of the intervals' translations, m. Turn: sum of
// their yaw, rad, counter-clockwise, not wrapped; the gyro's after removing the bias of the
// standstills (linear between two, constant before the first and after the last; with none, as it
// is).
struct DrMotion {
  double way_m = 0;
  double turn_rad = 0;
  double height_min_m = 0, height_max_m = 0;  // of T_OB, against the first state
  double tilt_max_rad = 0;                    // largest angle between z of B and z of O
  std::optional<double> wheel_way_m, wheel_turn_rad;
  std::optional<double> wheel_turned_rad;  // sum of the sizes of the turns
  std::optional<double> gyro_turn_rad;
  std::vector<Standstill> standstills;
  DurationUs covered;    // of the wheel intervals: by dead reckoning
  DurationUs uncovered;  // the rest of them
};
DrMotion MeasureMotion(const DrOnlyRun& run, const Calibration& calibration);

// Spans of time in which the filter flags slip.
struct SlipSpan {
  Utime begin, end;
};
std::vector<SlipSpan> SlipSpans(const std::vector<DrPose>& poses);

}  // namespace gw::tools

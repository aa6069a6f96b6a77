// The robot's motion as its sensors tell it, in camera time and body axes.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/config/robot_config.h"
#include "common/contract/samples.h"
#include "tools/lab/check/motion_fit.h"
#include "tools/lab/check/vision_motion.h"

namespace gw::check {

struct MotionSources {
  // Stamps as they were recorded, without the calibration's time offsets.
  std::array<MotionSum, 3> gyro_B;  // integral of the rate about x, y, z of the body as calibrated
  MotionSum wheel_turn, wheel_way;  // rad, m (forward)
  std::vector<MotionStep> wheel_turns;  // of about 0.1 s
  // Between neighbouring images that vision placed.
  std::vector<MotionStep> vision_turns;  // about z of the body, rad
  std::vector<MotionStep> vision_ways;   // forward, m; of steps that are mostly straight
  // Direction of straight motion in the body, as vision saw it: the median over the steps, so that
  // a pose that jumps when a place is found again does not count more than one step.
  double straight_yaw_rad = 0, straight_pitch_rad = 0;  // to the left of x, above the floor
  double straight_sigma_rad = 0;                        // the larger of both
  double straight_m = 0;

  // Sum of the turns up to t by what knows best: gyro, else wheels.
  std::optional<double> Turned(Utime t) const;
};

// vision: null where there are no images.
MotionSources MakeMotionSources(const std::vector<ImuSample>& imu,
                                const std::vector<WheelSample>& wheels, const VisionRun* vision,
                                const Calibration& calibration);

}  // namespace gw::check

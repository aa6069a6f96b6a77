// Wheel increments of what ROS bases publish beside odometry: joints of two wheels, encoder counts.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/contract/samples.h"
#include "common/core/result.h"
#include "tools/data/import/encoders.h"
#include "tools/data/import/ros_messages.h"

namespace gw::importer {

// The positions of a left and a right wheel in a JointState: the joints whose names hold "left" or
// "right" ("wheel_left_joint"), with "wheel" where several do. Empty when there are none.
struct WheelJoints {
  size_t left = 0, right = 0;
};
std::optional<WheelJoints> FindWheelJoints(const RosJoints& joints);

struct WheelAngles {
  Utime utime;
  double left_rad = 0, right_rad = 0;
};
// radius_m, track_m > 0. Precondition: times increase.
std::vector<WheelSample> WheelsFromAngles(const std::vector<WheelAngles>& angles, double radius_m,
                                          double track_m);

// Counts wrap at 65536: between two messages a wheel turns by less than half of that. Precondition:
// times increase.
std::vector<WheelSample> WheelsFromTicks(const std::vector<RosTicks>& ticks,
                                         const EncoderBase& base);

}  // namespace gw::importer

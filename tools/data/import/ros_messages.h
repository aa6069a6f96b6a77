// The ROS 1 messages that recordings hold, decoded from their bytes (little-endian, fields in
// order, arrays and strings with a 32-bit length in front), so that no ROS message package is
// needed. Layouts: sensor_msgs/Image, sensor_msgs/Imu, nav_msgs/Odometry, tf2_msgs/TFMessage.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/contract/samples.h"
#include "common/core/result.h"
#include "tools/data/import/recording.h"

namespace gw::importer {

using RosBytes = std::span<const uint8_t>;

// Stamp of the header, which the first three types begin with.
Result<Utime> DecodeRosStamp(RosBytes message);

// mono8 as it is, rgb8 and bgr8 as grey (see kGreyConversion). Error: kBadData.
Result<Image> DecodeRosGrey(RosBytes message);
// 16UC1 and mono16 as they are; 32FC1 (metres) rounded to depth_unit_m, values that are not finite,
// negative or too large for 16 bits become 0, no depth.
Result<Image> DecodeRosDepth(RosBytes message, double depth_unit_m);

Result<ImuSample> DecodeRosImu(RosBytes message);

struct RosPose {
  Utime utime;
  std::string child;  // without a slash in front
  SE3 T;
};
// Pose of the child frame in the header's frame.
Result<RosPose> DecodeRosOdometry(RosBytes message);

struct RosTransform {
  Utime utime;
  std::string parent, child;  // without a slash in front
  SE3 T;                      // pose of the child in the parent
};
Result<std::vector<RosTransform>> DecodeRosTransforms(RosBytes message);

}  // namespace gw::importer

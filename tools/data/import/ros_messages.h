// The ROS messages that recordings hold, decoded from their bytes, so that no ROS message package
// is needed. Layouts: sensor_msgs, nav_msgs, geometry_msgs, tf2_msgs, kobuki_msgs of ROS 1 and ROS
// 2, which differ in nothing but the serialisation (ros_reader.h). Images: ros_images.h.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/contract/samples.h"
#include "common/core/result.h"
#include "tools/data/import/ros_reader.h"

namespace gw::importer {

// All of these errors are kBadData and say what is wrong with the message.

// The header that most types begin with.
Result<RosReader::Header> DecodeRosHeader(const RosMessage& message);

Result<ImuSample> DecodeRosImu(const RosMessage& message);

struct RosPose {
  Utime utime;
  std::string parent, child;  // frames; child is empty where the type states none
  SE3 T;                      // pose of the child in the parent
};
// type: nav_msgs/Odometry, geometry_msgs/PoseStamped, PoseWithCovarianceStamped, TransformStamped.
Result<RosPose> DecodeRosPose(const RosMessage& message, const std::string& type);
bool IsPoseType(const std::string& type);
// tf2_msgs/TFMessage, tf/tfMessage.
Result<std::vector<RosPose>> DecodeRosTransforms(const RosMessage& message);

// sensor_msgs/CameraInfo.
struct RosCameraInfo {
  std::string frame;
  int width = 0, height = 0;  // that the numbers are stated for
  std::string model;          // plumb_bob, rational_polynomial, equidistant, ...
  std::vector<double> D;
  std::array<double, 9> K{}, R{};  // row by row
  std::array<double, 12> P{};
  int binning_x = 0, binning_y = 0, offset_x = 0, offset_y = 0;
};
Result<RosCameraInfo> DecodeRosCameraInfo(const RosMessage& message);

// sensor_msgs/JointState.
struct RosJoints {
  Utime utime;
  std::vector<std::string> names;
  std::vector<double> positions;  // rad, as many as names, or none
};
Result<RosJoints> DecodeRosJoints(const RosMessage& message);

// kobuki_msgs/SensorState, kobuki_ros_interfaces/SensorState: counts of the encoders, and contacts.
struct RosTicks {
  Utime utime;
  uint16_t left = 0, right = 0;
  ContactFlags contact;
};
Result<RosTicks> DecodeKobukiTicks(const RosMessage& message);

}  // namespace gw::importer

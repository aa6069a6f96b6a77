// Which topic of a bag is what.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/camera/calibration.h"
#include "common/core/result.h"
#include "tools/data/bag/bag.h"

namespace gw::importer {

// Topics as the user names them; empty: found by type, "none": left out.
struct TopicWishes {
  std::string stereo;    // "LEFT,RIGHT"
  std::string rgbd;      // "IMAGE,DEPTH"
  std::string odometry;  // nav_msgs/Odometry, sensor_msgs/JointState, kobuki SensorState
  std::string imu;       // sensor_msgs/Imu, or "GYRO,ACCELEROMETER" of two such topics
  std::string truth;     // of a pose type
  // The kind in the calibration that is given, if one is: decides where a bag has cameras of both
  // kinds.
  std::optional<CameraKind> kind;
};

// Indices in Bag::topics().
struct RosTopics {
  std::optional<uint32_t> left, right, depth;     // right or depth, or neither: no images
  std::optional<uint32_t> left_info, right_info;  // CameraInfo of left and right
  std::optional<uint32_t> odometry;
  std::optional<uint32_t> imu, accel;  // accel: where the gyro is another topic's
  std::optional<uint32_t> truth;
  std::vector<std::string> choices;  // what is taken as what, and what else could be
};

// By the types, then by what the first messages and the names say: a depth image is one of 16 or 32
// bits whose name or format says so; it belongs to the image of its own frame; eyes differ in
// "left" and "right", "infra1" and "infra2", "cam0" and "cam1". Where a bag has both, RGB-D is
// taken, unless a calibration says otherwise: the eyes of a depth camera see its dots. Error:
// kBadData for a topic that is wished for but not there or of another type; the message lists those
// that are.
Result<RosTopics> ChooseTopics(bag::Bag& bag, const TopicWishes& wishes);

// One line for each topic of a bag: name, type, messages, rate.
std::string ListTopics(const bag::Bag& bag);

}  // namespace gw::importer

// Recordings of ROS robots: ROS 1 bags, rosbag2 (SQLite3, MCAP), with or without their index.
#pragma once

#include <filesystem>
#include <string>

#include "tools/data/import/cid_sims.h"
#include "tools/data/import/recording.h"
#include "tools/data/import/ros_topics.h"

namespace gw::importer {

struct RosbagOptions {
  TopicWishes topics;
  // Ground truth as a transform of tf, where no topic is one.
  std::string truth_parent = "world", truth_child = "base_link_gt";
  // Geometry of a base whose odometry is JointState or ticks; 0: those of the calibration.
  double wheel_radius_m = 0, track_m = 0;
  // In place of what the bag says about the sensors: section `calibration` of a robot's YAML, or
  // the data set's file, with mount.
  std::filesystem::path robot_config;
  std::filesystem::path cid_sims_calibration;
  std::string mount;
};

// Body: the frame that the odometry is of, base_footprint where that is straight above or below it.
// Camera: CameraInfo and tf (ros_camera.h); images pair with their partner by stamp, within half of
// a frame's time. Errors: kNotFound, kBadData, kInvalidArgument for topics that are wished for.
Result<Recording> ReadRosbag(const std::filesystem::path& file, const RosbagOptions& options);

// What a bag holds and what would be imported of it, for people.
Result<std::string> ListRosbag(const std::filesystem::path& file, const RosbagOptions& options);

}  // namespace gw::importer

// ROS 1 bags, through Debian's rosbag storage library where the build has it.
#pragma once

#include <filesystem>
#include <string>

#include "tools/data/import/cid_sims.h"
#include "tools/data/import/recording.h"

namespace gw::importer {

// Topics as CID-SIMS names them; an empty name leaves the stream out.
struct RosbagOptions {
  std::string left = "/camera/color/image_raw";                    // mono8, rgb8 or bgr8
  std::string depth = "/camera/aligned_depth_to_color/image_raw";  // 16UC1 or 32FC1
  std::string imu = "/camera/imu";
  std::string odometry = "/odom";
  std::string transforms = "/tf";
  std::string truth_parent = "world", truth_child = "base_link_gt";  // on `transforms`
  // One of the two. A bag holds no complete calibration.
  std::filesystem::path robot_config;          // section `calibration` of a robot's YAML
  std::filesystem::path cid_sims_calibration;  // the data set's file, with mount
  std::string mount;
};

// True when this build can read bags.
bool HasRosbagSupport();

// RGB-D: images pair with the nearest depth within 20 ms. Ground truth is the pose of the body.
// Error: kInvalidArgument when this build cannot read bags.
Result<Recording> ReadRosbag(const std::filesystem::path& file, const RosbagOptions& options);

}  // namespace gw::importer

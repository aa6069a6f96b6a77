// Wheels, and an IMU where there is one, without images: text files that any robot can write.
#pragma once

#include <filesystem>

#include "tools/data/import/recording.h"

namespace gw::importer {

enum class ImuColumns { kGyroAccel, kAccelGyro };

struct OdometryOptions {
  std::filesystem::path imu;                        // lines `t wx wy wz [ax ay az]`; empty: none
  ImuColumns imu_columns = ImuColumns::kGyroAccel;  // kAccelGyro: `t ax ay az wx wy wz`
  std::filesystem::path ground_truth;  // lines `t x y z qx qy qz qw` of the body; empty: none
};

// source: the file of odometry poses, lines `t x y z qx qy qz qw` (s, m), blanks or commas between.
// Body: the odometry's. The IMU is taken to have the axes of the body (x forward, y left, z up);
// units and clock are CheckImu's. Increments are taken between poses, so that a pose that repeats a
// time, or is of no use, loses no way.
Result<Recording> ReadOdometry(const std::filesystem::path& source, const OdometryOptions& options);

}  // namespace gw::importer

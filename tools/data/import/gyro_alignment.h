// Which of two rotations puts the gyro into the camera's frame.
#pragma once

#include <vector>

#include "common/contract/samples.h"
#include "tools/data/import/trajectory.h"

namespace gw::importer {

// Root mean square difference (rad/s) between the camera's angular velocity, from ground truth over
// steps of about 0.1 s, and the mean gyro reading of the step turned by R_CI, after removing the
// constant part (gyro bias). t_imu = t_camera + time_offset_s. Negative when fewer than 10 steps
// are covered by both.
double GyroDisagreement(const std::vector<StampedPose>& T_GC, const std::vector<ImuSample>& imu,
                        const Eigen::Quaterniond& R_CI, double time_offset_s);

}  // namespace gw::importer

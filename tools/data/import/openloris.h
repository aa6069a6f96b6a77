// OpenLORIS-Scene (Shi et al. 2020): D435i RGB-D, gyro, accelerometer, wheel odometry, on a real
// robot.
#pragma once

#include <filesystem>

#include "tools/data/import/recording.h"

namespace gw::importer {

struct OpenLorisOptions : ReadOptions {
  // Instead of odom.txt: the encoders' own readings, lines `t left right` (ticks); radius and track
  // are those of sensors.yaml, ticks_per_turn (> 0) of a wheel is needed.
  std::filesystem::path encoders;
  double ticks_per_turn = 0;
};

// Body: the frame `odometer` of trans_matrix.yaml, base_link where that is not stated. The colour
// camera with the depth aligned to it (color.txt, aligned_depth.txt, sensors.yaml,
// trans_matrix.yaml); without aligned_depth.txt the stereo pair color.txt, infra2.txt. A folder
// without color.txt gives a log of odometry, IMU and ground truth alone, with a camera calibration
// that is only nominal; the log says so. Gyro and accelerometer are sampled at different instants:
// the log has the gyro's, with the accelerometer interpolated to them.
Result<Recording> ReadOpenLoris(const std::filesystem::path& source,
                                const OpenLorisOptions& options);

}  // namespace gw::importer

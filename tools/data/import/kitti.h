// KITTI odometry (Geiger et al. 2012): image_0, image_1, calib.txt, times.txt, poses.txt.
#pragma once

#include <filesystem>

#include "tools/data/import/recording.h"

namespace gw::importer {

// Body: at the left camera's optical centre, x forward, y left, z up. The frame of the ground truth
// is the first body pose (z up), where the files use the first camera pose.
Result<Recording> ReadKitti(const std::filesystem::path& source, const ReadOptions& options);

}  // namespace gw::importer

// Intrinsics belong to the image size that they were measured at.
#pragma once

#include <string>
#include <vector>

#include "common/camera/calibration.h"
#include "common/core/result.h"

namespace gw::importer {

// The intrinsics of an eye are stated for images of stated_width x stated_height; those of the
// recording are camera.width x camera.height. Where both have one shape the images were resized:
// the intrinsics are scaled with them, and `warnings` says so. Error kBadData, after `where`: any
// other size (a crop, another mode of the camera), for which the intrinsics cannot be known.
Result<Done> FitStatedSize(double stated_width, double stated_height, const std::string& where,
                           const CameraCalibration& camera, PinholeIntrinsics* eye,
                           std::vector<std::string>& warnings);

}  // namespace gw::importer

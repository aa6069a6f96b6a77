// Where the camera really sits: a bracket holds it to half a degree to a degree and a centimetre,
// and the calibration says where it should be.
#pragma once

#include <cstdint>

#include "common/core/se3.h"

namespace gw::sim {

// Sizes of the errors; see DrawError. A printed or bent bracket, set up by hand.
struct MountingConfig {
  double camera_deg = 0.75;  // rotation about an axis of any direction
  double camera_m = 0.01;    // shift in any direction
};

// True pose of the camera in the body; nominal: what the robot's configuration says.
SE3 MountedAt(const SE3& nominal_T_BC, const MountingConfig& config, uint64_t seed);

}  // namespace gw::sim

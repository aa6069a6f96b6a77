// Moves the features of a rolling-shutter image to where a global shutter would have seen them at
// the image's mid-exposure: each row is exposed a little later than the one above, while the camera
// turns.
//
// Rotation only: at 80 deg/s and a readout of 26 ms the outer rows are off by 8 px; translation
// moves a point at 1 m by less than a tenth of that at walking speed.
#pragma once

#include "common/camera/camera_model.h"
#include "frontend/core/features/feature_frame.h"

namespace gw::frontend {

// w_C: angular velocity of the camera in its own frame, rad/s. readout_s: from the first to the
// last row; rows are those of the rectified image, which is near enough. Depth stays; u_right
// follows u.
void UndoRollingShutter(const RectifiedCamera& camera, double readout_s, const Eigen::Vector3d& w_C,
                        std::vector<Feature>* features);

}  // namespace gw::frontend

// The body frame of a recording: chosen so that the wheels are right.
#pragma once

#include "common/core/se3.h"
#include "tools/data/import/recording.h"

namespace gw::importer {

// The wheels' frame N becomes the body of the recording. Dead reckoning takes wheel increments as
// motion of the body (docs/conventions.md: on the floor under the axle's centre, x forward, z up),
// so the body has to be where the wheels are, whatever frame the data set calls its body.
//
// T_BN: pose of the wheels' frame in the body that the recording has so far. Extrinsics of camera
// and IMU and the ground truth are expressed anew; wheel increments are of N and stay.
void MoveBodyToWheels(const SE3& T_BN, Recording& recording);

}  // namespace gw::importer

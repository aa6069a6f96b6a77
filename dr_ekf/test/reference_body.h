// A recording's reference may be of another point of the robot than the one its wheels are counted
// for, and of another clock: that is no error of dead reckoning.
#pragma once

#include <vector>

#include "common/core/se3.h"
#include "dr_ekf/test/recordings.h"

namespace gw::dr_ekf {

struct ReferenceBody {
  SE3 T_BR;                  // planar; R: what the reference is the pose of
  double clock_ahead_s = 0;  // stamps of the reference minus those of the wheels
};

// The one for which the motions over a second agree best with those of the wheels (hand-eye
// calibration in the plane, robust; the scale of the wheels is left open). All but the fit's three
// or four numbers are as recorded, and there are hundreds of windows.
ReferenceBody FitReferenceBody(const std::vector<StampedPose>& reference,
                               const std::vector<StampedPose>& wheels);

// The reference as poses of B in some world, with the stamps of the wheels' clock.
std::vector<StampedPose> InBodyOfWheels(const std::vector<StampedPose>& reference,
                                        const ReferenceBody& body);

double MedianPeriod(const std::vector<StampedPose>& poses);  // s

}  // namespace gw::dr_ekf

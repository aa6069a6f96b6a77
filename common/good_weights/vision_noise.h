// What a pose from vision is worth: the inverse of its information, made honest (docs/method.md,
// section 5.6).
#pragma once

#include "common/core/se3.h"

namespace gw {

// Standard deviations of the visual estimate of a pose, as multiples of what the inverse of its
// information says, in camera axes [translation; rotation]. Above one because the errors of an
// image's landmarks are not independent of each other: they were placed from few views, most of all
// along the optical axis. Below one where many landmarks at the image's rim over-determine the
// angle. Measured on simulated drives in stereo, of which the test drives are others
// (docs/results-paper.md, consistency).
Vector6d VisionInflation();

// cov with each axis scaled by VisionInflation.
Matrix6d Inflated(const Matrix6d& cov);

// Covariance of a pose that vision found with this information, for known landmarks. Precondition:
// the information is positive definite.
Matrix6d VisionCovariance(const Matrix6d& vision_information);

}  // namespace gw

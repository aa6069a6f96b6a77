// How strongly dead reckoning (DR) ties two keyframes that follow each other: the covariance of
// their edge in local bundle adjustment, in the pose graph of loops and in global bundle adjustment
// (docs/method.md, sections 3.5 and 3.6).
#pragma once

#include "common/config/dr_weight_config.h"
#include "common/core/chi_square.h"
#include "common/core/se3.h"
#include "common/good_weights/camera_motion.h"

namespace gw {

// Sigma_d / alpha, alpha > 0. Where alpha follows the quality of tracking, the edge is not believed
// more than the filter believes itself (docs/adr/0012-no-more-than-dr-knows.md), but by the paper's
// law it is.
Matrix6d EdgeCovariance(const DrMotion& motion, double alpha, Variant variant,
                        const DrWeightConfig& config);

// Squared radius of Cauchy's loss on an edge of dead reckoning in local and global bundle
// adjustment. An edge that is honest is hardly touched by it, one that contradicts what hundreds of
// observations say lets go.
inline constexpr double kDrRadius2 = kChi2Six999;

// Against a loop an edge counts no more than its drift allows, whatever alpha makes of it against
// single observations: no loop across a weak span could ever close else.
Matrix6d LoopEdgeCovariance(const DrMotion& motion, double alpha, Variant variant,
                            const DrWeightConfig& config);

// In a bundle adjustment of the whole map, where observations count as if their errors were
// independent. Over a lap they are not, and what alpha says of one image is no measure of it: where
// alpha follows the quality of tracking and the filter reports a covariance, the way of DR counts
// for all it knows (as for a blind image), and as much more as the observations count too much
// (VisionInflation). Its turn counts as in local bundle adjustment: the errors of headings that
// follow each other are one bias, which edges that are independent of each other would take for
// knowledge (docs/adr/0015-dead-reckoning-in-global-ba.md). By the paper's law: that of local
// bundle adjustment.
Matrix6d WholeMapEdgeCovariance(const DrMotion& motion, double alpha, Variant variant,
                                const DrWeightConfig& config);

}  // namespace gw

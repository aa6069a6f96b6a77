// The health of visual tracking, as a number between 0 (blind) and 1 (healthy): of one image, and
// of the tie between two keyframes that follow each other (docs/method.md, sections 3.2 and 3.4).
#pragma once

#include "common/config/dr_weight_config.h"
#include "common/contract/tracking.h"

namespace gw {

// Counts of one image.
struct TrackingHealth {
  int num_detected = 0;  // features found in the image
  int num_tracked = 0;   // of them matched to the local map in the first stage
};

// Q = omega clip(N_det / N_det_ref, 0, 1) + (1 - omega) clip(N_trk / N_trk_ref, 0, 1)
// (Du, Peng, Vela, "Good Weights", arXiv 2509.22910, equation 5).
double ImageQuality(const TrackingHealth& health, const DrWeightConfig& config);

// Q_ij = min(clip(C_ij / C_ref, 0, 1), Q_j). C_ij: close landmarks that both keyframes observe;
// C_ref > 0: how many it takes for full quality; Q_j: ImageQuality of the newer keyframe, which
// bounds it (docs/adr/0010-dr-edges-of-local-ba.md). In [0, 1].
double EdgeQuality(double shared_close, double connection_reference, double quality_of_newer);

// An edge of a chain lacks quality 1 - Q. The lack reaches the neighbours along the chain, halved
// with every hop: this is what is left of it `hops` edges away. An edge takes the largest of its
// own and of what reaches it from at most kSmoothingHops away, so that a poorly connected keyframe
// strengthens its neighbours and never loses its own support to them (Du, Peng, Vela, "Good
// Weights", arXiv 2509.22910, figure "dr_ba"; the kernel is ours:
// docs/adr/0010-dr-edges-of-local-ba.md).
inline constexpr int kSmoothingHops = 3;
double LackReaching(double lack, int hops);

// Lack from which an edge counts as weak: vision does not carry it.
inline constexpr double kWeakLack = 0.5;

// Quality from which vision counts as healthy.
inline constexpr double kHealthyQuality = 0.9;

// True when vision carries the pose of this image in full health, and mostly by itself: only then
// may the pose judge dead reckoning. A judge sees an error of dead reckoning smaller by its own
// share.
bool VisionMayJudgeDr(const FramePose& frame);

}  // namespace gw

// FRAME_DETAIL of one image: what became of its features, and how much dead reckoning counts in its
// pose, per axis. For people; nothing is decided by it.
#pragma once

#include <vector>

#include "common/config/dr_weight_config.h"
#include "common/contract/frame_detail.h"
#include "common/contract/map.h"
#include "frontend/core/features/feature_frame.h"
#include "frontend/core/tracking/pose_finder.h"

namespace gw::frontend {

struct DetailInput {
  Utime utime = {};
  int64_t seq = 0;
  const FeatureFrame* frame = nullptr;
  const FoundPose* found = nullptr;
  bool vision = false;     // the pose that was found is believed
  bool from_dr = false;    // there is a prior from dead reckoning
  bool dr_trusted = true;  // it does not contradict healthy vision
  SE3 T_BC = {};
};

FrameDetail ExplainFrame(const DetailInput& input, const DrWeightConfig& config);

// Features that became landmarks with `keyframe`, made of the same image.
void MarkNewLandmarks(const Keyframe& keyframe, FrameDetail* detail);

// The weight of the prior in the mean, along and about the axes of B: the diagonal of
// (H_v + H_p)^-1 H_p, which solves (H_v + H_p) x = H_v x_vision + H_p x_prior. Informations of
// right perturbations of T_WC. Zero where there is no prior.
Vector6d PriorShare(const Matrix6d& vision, const Matrix6d& prior, const SE3& T_BC);

}  // namespace gw::frontend

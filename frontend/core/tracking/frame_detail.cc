#include "frontend/core/tracking/frame_detail.h"

#include <Eigen/Cholesky>

namespace gw::frontend {
namespace {

AlphaBound BoundOf(const DetailInput& input, const DrWeightConfig& config) {
  if (!input.dr_trusted) return AlphaBound::kDistrusted;
  if (!input.from_dr) return AlphaBound::kUnused;
  if (!input.vision) return AlphaBound::kAlphaMax;
  const FoundPose& found = *input.found;
  if (found.estimate.prior_information.isZero(0)) return AlphaBound::kUnused;
  // Up to rounding of the covariances the two are equal where nothing bounds.
  const double unbounded = found.scale.translation + found.scale.rotation;
  if (found.bounded.translation + found.bounded.rotation < 0.9 * unbounded) {
    return AlphaBound::kCovariance;
  }
  if (found.scale.rotation <= config.alpha_min) return AlphaBound::kAlphaMin;
  if (found.scale.rotation >= config.alpha_max) return AlphaBound::kAlphaMax;
  return AlphaBound::kNone;
}

FeatureFate FateOf(const FoundPose& found, size_t i) {
  if (i < found.landmarks.size() && found.landmarks[i].valid()) return FeatureFate::kInlier;
  if (i < found.outlier.size() && found.outlier[i] != 0) return FeatureFate::kOutlier;
  return FeatureFate::kUnmatched;
}

}  // namespace

Vector6d PriorShare(const Matrix6d& vision, const Matrix6d& prior, const SE3& T_BC) {
  if (prior.isZero(0)) return Vector6d::Zero();
  // A perturbation in B is Ad(T_BC) times that in C.
  const Matrix6d in_B = T_BC.Adjoint();
  const Matrix6d gain_C = (vision + prior).ldlt().solve(prior);
  const Vector6d share = (in_B * gain_C * T_BC.inverse().Adjoint()).diagonal();
  return share.cwiseMax(0.0).cwiseMin(1.0);
}

FrameDetail ExplainFrame(const DetailInput& input, const DrWeightConfig& config) {
  FrameDetail detail;
  detail.utime = input.utime;
  detail.seq = input.seq;
  const FoundPose& found = *input.found;
  detail.q = found.q;
  detail.q_close = found.q_close;
  detail.bound = BoundOf(input, config);
  if (input.from_dr) {
    detail.alpha_translation = found.scale.translation;
    detail.alpha_rotation = found.scale.rotation;
    detail.bounded_translation = found.bounded.translation;
    detail.bounded_rotation = found.bounded.rotation;
  }
  if (input.vision) {
    detail.dr_share =
        PriorShare(found.estimate.vision_information, found.estimate.prior_information, input.T_BC);
  } else if (input.from_dr) {
    detail.dr_share.setOnes();
  }
  detail.features.reserve(input.frame->features.size());
  for (size_t i = 0; i < input.frame->features.size(); ++i) {
    const Feature& f = input.frame->features[i];
    detail.features.push_back({f.u, f.v, FateOf(found, i)});
  }
  return detail;
}

void MarkNewLandmarks(const Keyframe& keyframe, FrameDetail* detail) {
  for (size_t i = 0; i < keyframe.landmarks.size() && i < detail->features.size(); ++i) {
    if (keyframe.landmarks[i] != LandmarkId::From(keyframe.id, static_cast<int>(i))) continue;
    detail->features[i].fate = FeatureFate::kNew;
  }
}

}  // namespace gw::frontend

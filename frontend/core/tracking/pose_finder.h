// The pose of one image in the map: which landmarks do its features show, and where does the camera
// stand then?
//
//   Follow     around a prediction, in two stages: the landmarks of the last image (or those near
//              the prediction), then the rest of the local map in small windows
//   FindAgain  without a prediction, among the landmarks near a place
//   FollowRest around a prediction, by what another pose leaves unexplained, if that confirms the
//              prediction (docs/method.md, eq. 5.3a)
//
// Holds no state of the track: what was tracked before is an argument, what is tracked now a
// result.
#pragma once

#include <optional>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/config/frontend_config.h"
#include "common/contract/tracking.h"
#include "common/good_weights/alpha.h"
#include "common/vision/feature_grid.h"
#include "common/vision/pose_optimizer.h"
#include "common/vision/pyramid.h"
#include "frontend/core/features/feature_frame.h"
#include "frontend/core/map/local_map.h"
#include "frontend/core/map/projection_matcher.h"
#include "frontend/core/map/standing_landmarks.h"
#include "frontend/core/map/tracked_points.h"
#include "frontend/core/tracking/good_features.h"

namespace gw::frontend {

// Where to look, and how much the prediction counts.
struct PosePrediction {
  SE3 T_WC;
  Matrix6d search_cov = Matrix6d::Identity();  // of T_WC: how far the windows have to reach
  // Prior of the pose (Good Weights): alpha(Q) * inv(weight_cov), however large alpha, with a
  // covariance not below honest_cov (docs/adr/0012-no-more-than-dr-knows.md). Unused without
  // has_prior.
  bool has_prior = false;
  // The prior makes the problem well posed with any number of matches: the paper's law. Else fewer
  // than FrontendConfig::min_inliers make no pose.
  bool any_matches = false;
  Matrix6d weight_cov = Matrix6d::Identity();
  Matrix6d honest_cov = Matrix6d::Zero();
  bool vision_broken = false;  // no visual pose in the image before: search near the prediction
};

struct FoundPose {
  bool found = false;
  TrackingReason reason = TrackingReason::kNone;  // why not
  PoseEstimate estimate;
  std::vector<LandmarkId> landmarks;  // per feature; invalid: none, or an outlier
  std::vector<uint8_t> outlier;       // per feature: 1 when it was matched and set aside
  // Inliers, had everything been looked for that should be in sight; with a budget an estimate.
  int num_matchable = 0;
  int num_tracked = 0;  // N_trk: matches of the first stage
  double q = 0;
  double q_close = 0;    // quality of the features with depth
  DrScale scale;         // what the variant makes of the quality
  DrScale bounded;       // and what is left of it after the bound
  KeyframeId reference;  // the keyframe that shares most with the image
};

class PoseFinder {
 public:
  // A pose with a smaller share of its matches as inliers may be a wrong one.
  static constexpr double kTrustedShare = 0.4;

  PoseFinder(const FrontendConfig& config, const RectifiedCamera& camera, const Pyramid& pyramid);

  // To be called first for every image. seed: of the choice of landmarks.
  void SetImage(const FeatureFrame* frame, uint64_t seed);

  FoundPose Follow(const PosePrediction& prediction, const std::vector<TrackedPoint>& tracked,
                   KeyframeId reference, LocalMap* map);
  FoundPose FindAgain(const SE3& T_WC_near, uint64_t seed, LocalMap* map);
  FoundPose FollowRest(const PosePrediction& prediction, const FoundPose& other,
                       KeyframeId reference, LocalMap* map) const;

  // Looks for the landmarks that were left out, around the pose that was found, which stays. An
  // image that becomes a keyframe should show them all, or the map gets them twice.
  void Complete(LocalMap* map, FoundPose* found) const;

 private:
  struct Association {
    std::vector<Candidate> candidates;
    std::vector<int> match;        // per feature: index into candidates, or -1
    std::vector<uint8_t> outlier;  // per feature
    PoseEstimate estimate;
    int num_first_stage = 0;
    double left_out = 0;  // matches expected of what the budget left out
    double quality = 0;
    double quality_close = 0;
    DrScale scale;
  };

  struct Rest {              // of the image, seen from one pose, that another does not explain
    std::vector<int> match;  // per feature: the candidate that it fits to, or -1
    int fitting = 0;
    int similar = 0;  // features that look like a candidate in its window, and tell
  };

  bool Fits(size_t feature, const Eigen::Vector3d& p_C) const;
  Rest RestAt(const SE3& T_WC, const SE3& T_WC_other, const std::vector<Candidate>& candidates,
              std::vector<int> match) const;
  float SearchRadius(const Matrix6d& cov) const;
  bool IsFounded(const PosePrediction& prediction, const Association& a, int fewest) const;
  int FewestMatches(const PosePrediction& prediction, const DrScale& scale) const;
  std::optional<PosePrior> PriorFor(const PosePrediction& prediction, const DrScale& scale) const;
  SearchableImage Image() const { return {frame_->features, frame_->descriptors, grid_}; }
  int Match(const SE3& T_WC, std::vector<Candidate> candidates, const MatcherLimits& limits,
            int budget, Association* a) const;
  std::vector<Candidate> AroundMatched(const std::vector<LandmarkId>& ids, KeyframeId* reference,
                                       LocalMap* map) const;
  void FirstStage(const PosePrediction& prediction, Association* a) const;
  void Estimate(const SE3& T_WC_start, const std::optional<PosePrior>& prior, Association* a) const;
  void SearchLocalMap(const std::optional<PosePrior>& prior, KeyframeId* reference, LocalMap* map,
                      Association* a) const;
  FoundPose Result(const Association& a, KeyframeId reference) const;

  FrontendConfig config_;
  RectifiedCamera camera_;
  Pyramid pyramid_;
  ProjectionMatcher matcher_;
  GoodFeatures good_;
  FeatureGrid grid_;
  const FeatureFrame* frame_ = nullptr;
  uint64_t seed_ = 0;
  int num_close_ = 0;  // features of the image with depth
};

}  // namespace gw::frontend

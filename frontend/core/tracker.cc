#include "frontend/core/tracker.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/contract/dr_history.h"
#include "common/vision/pose_optimizer.h"
#include "frontend/core/dr_weight.h"
#include "frontend/core/feature_grid.h"
#include "frontend/core/keyframe_policy.h"
#include "frontend/core/local_map.h"
#include "frontend/core/projection_matcher.h"
#include "frontend/core/relocalizer.h"
#include "frontend/core/rolling_shutter.h"

namespace gw::frontend {
namespace {

constexpr int kMinInitialLandmarks = 50;  // fewer do not carry the next image
constexpr int kFewMatches = 20;           // first stage: with fewer inliers the window is doubled
constexpr double kTrustedShare = 0.4;  // ... also when a smaller share of the matches are inliers
constexpr int kAttempts = 3;
constexpr int kLocalKeyframes = 40;
constexpr int kRecoveryKeyframes = 8;
constexpr int kRelocalizedInliers = 30;     // a pose found without a prediction needs more support
constexpr float kSecondStageRadius = 6.0F;  // px at level 0: the pose is known by then
constexpr float kMaxRadius = 80.0F;         // px
constexpr DurationUs kMaxDrExtrapolation = Milliseconds(60);
constexpr DurationUs kMaxCoasting = Milliseconds(500);  // constant velocity is believed this long
// Spread of the real motion around constant velocity per 1/30 s (hand-held recording, 95 % of
// images).
constexpr double kCoastingSigmaRotation = 0.008;     // rad
constexpr double kCoastingSigmaTranslation = 0.010;  // m

// Moves the covariance of a pose along an increment: the error of T_a seen at T_a * T_ab.
Matrix6d Transport(const Matrix6d& cov, const SE3& T_ab) {
  const Matrix6d adj = T_ab.inverse().Adjoint();
  return adj * cov * adj.transpose();
}

struct TrackedPoint {
  LandmarkId id;
  Descriptor descriptor;  // as seen in the last image
  int level = 0;
};

struct Prediction {
  SE3 T_WC;
  Matrix6d motion_cov = Matrix6d::Identity();  // of the motion since the last image, camera tangent
  bool from_dr = false;
  bool slip = false;
};

}  // namespace

class Tracker::Impl {
 public:
  Impl(const FrontendConfig& config, const CameraGeometry& geometry, FeatureExtractor extractor)
      : config_(config),
        camera_(geometry.rectified),
        scale_{config.orb.scale_factor, config.orb.num_levels},
        extractor_(std::move(extractor)),
        matcher_(camera_, scale_),
        map_(camera_, scale_) {}

  TrackerOutput Push(const CameraFrame& frame);
  TrackerOutput Track(Utime utime, int64_t seq, const FeatureFrame& features,
                      TrackingReason image_problem);
  bool Push(const DrState& state);
  bool Push(const MapUpdate& update);
  void Push(const Pose& pose);
  MapRequest Request() const;
  bool has_map() const { return map_known_; }

 private:
  struct Association {
    std::vector<Candidate> candidates;
    std::vector<int> match;  // per feature: index into candidates, or -1
    PoseEstimate estimate;
    std::vector<int> feature_of;  // per observation of the estimate
    int num_first_stage = 0;
  };

  bool VariantUsesDr() const { return DrPredicts(config_.variant); }
  Prediction Predict(Utime utime) const;
  std::optional<DrIncrement> DrBetween(Utime a, Utime b) const {
    return dr_.Increment(a, b, kMaxDrExtrapolation);
  }
  Matrix6d ToCamera(const Matrix6d& cov_B) const;
  float SearchRadius(const Matrix6d& cov) const;
  void Estimate(const FeatureFrame& frame, const SE3& T_WC_start,
                const std::optional<PosePrior>& prior, Association* a) const;
  bool FollowMap(const FeatureFrame& frame, const Prediction& prediction, FramePose* report,
                 Association* a);
  bool FindAgain(const FeatureFrame& frame, Utime utime, FramePose* report, Association* a);
  void SearchLocalMap(const FeatureFrame& frame, const std::optional<PosePrior>& prior,
                      Association* a);
  std::optional<PosePrior> PriorFor(const Prediction& prediction, double alpha) const;
  void Accept(const Association& a, const FeatureFrame& frame, const Prediction& prediction,
              FramePose* report);
  bool WantsKeyframe(Utime utime, const FeatureFrame& frame, const Association& a,
                     bool vision) const;
  Keyframe MakeKeyframe(Utime utime, const FeatureFrame& frame, const Association& a,
                        const FramePose& report);
  void Begin(const Prediction& prediction);
  void FillPose(FramePose* report) const;

  FrontendConfig config_;
  RectifiedCamera camera_;
  PyramidScale scale_;
  FeatureExtractor extractor_;
  ProjectionMatcher matcher_;
  LocalMap map_;
  DrHistory dr_;
  FeatureFrame frame_;
  FeatureGrid grid_;

  bool map_known_ = false;  // a snapshot has come
  bool has_image_ = false;
  bool placed_ = false;  // the pose refers to the map, not only to the start of this process
  Utime utime_;          // of the last image
  SE3 T_WC_;
  Matrix6d cov_ = Matrix6d::Zero();        // of T_WC_, camera tangent
  Matrix6d blind_cov_ = Matrix6d::Zero();  // motion since vision last carried the pose
  Vector6d velocity_ = Vector6d::Zero();   // camera twist, 1/s
  Utime last_vision_;
  std::vector<TrackedPoint> tracked_;
  std::optional<Pose> hint_;

  KeyframeId reference_;      // keyframe the pose is expressed in
  KeyframeId last_keyframe_;  // newest of our own
  KeyframeId next_keyframe_{1};
  Utime keyframe_utime_;
  SE3 T_CkeyC_;  // motion since the last keyframe
  int reference_inliers_ = 0;
  int images_since_keyframe_ = 0;
};

Matrix6d Tracker::Impl::ToCamera(const Matrix6d& cov_B) const {
  const Matrix6d adj = camera_.T_BC.inverse().Adjoint();
  return adj * cov_B * adj.transpose();
}

Prediction Tracker::Impl::Predict(Utime utime) const {
  Prediction out;
  if (!has_image_) {
    // W: origin and heading at the first body pose, gravity-aligned where DR knows gravity.
    SE3 T_WB;
    if (VariantUsesDr() && !dr_.empty() && dr_.newest().gravity_aligned) {
      if (const auto T_OB = dr_.PoseAt(utime, kMaxDrExtrapolation)) {
        const Eigen::Matrix3d R = T_OB->rotation().toRotationMatrix();
        const double yaw = std::atan2(R(1, 0), R(0, 0));
        T_WB = SE3(ExpSO3({0, 0, -yaw}) * T_OB->rotation(), Eigen::Vector3d::Zero());
      }
    }
    out.T_WC = T_WB * camera_.T_BC;
    out.motion_cov.setZero();
    return out;
  }
  const DurationUs dt = utime - utime_;
  if (VariantUsesDr()) {
    // The one place where DR, a body quantity, becomes a camera quantity.
    if (const auto increment = DrBetween(utime_, utime)) {
      out.T_WC = T_WC_ * (camera_.T_BC.inverse() * increment->T_BaBb * camera_.T_BC);
      out.motion_cov = DrCovariance(dt, ToCamera(increment->cov), config_.dr_weight);
      out.from_dr = true;
      out.slip = increment->slip;
      return out;
    }
  }
  const bool coasting = utime - last_vision_ <= kMaxCoasting;
  out.T_WC = coasting ? T_WC_ * SE3::Exp(velocity_ * dt.seconds()) : T_WC_;
  const double frames = dt.seconds() * 30.0;
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(kCoastingSigmaTranslation),
      Eigen::Vector3d::Constant(kCoastingSigmaRotation);
  sigma *= frames;
  out.motion_cov = sigma.cwiseAbs2().asDiagonal();
  return out;
}

float Tracker::Impl::SearchRadius(const Matrix6d& cov) const {
  constexpr double kTypicalDepth = 2.0;  // m
  const double sigma_r = std::sqrt(cov.diagonal().tail<3>().maxCoeff());
  const double sigma_t = std::sqrt(cov.diagonal().head<3>().maxCoeff());
  const double px = camera_.fx * std::hypot(sigma_r, sigma_t / kTypicalDepth);
  return std::min(static_cast<float>(3.0 + 2.5 * px), kMaxRadius);
}

// Pose from the current associations; outliers lose their match.
void Tracker::Impl::Estimate(const FeatureFrame& frame, const SE3& T_WC_start,
                             const std::optional<PosePrior>& prior, Association* a) const {
  std::vector<PoseObservation> observations;
  a->feature_of.clear();
  for (size_t i = 0; i < a->match.size(); ++i) {
    if (a->match[i] < 0) continue;
    const Feature& f = frame.features[i];
    const double s = matcher_.LevelScale(f.level);
    observations.push_back(
        {a->candidates[a->match[i]].point->p_W, f.u, f.v, f.u_right, f.has_depth(), 1.0 / (s * s)});
    a->feature_of.push_back(static_cast<int>(i));
  }
  a->estimate = OptimizePose(camera_, T_WC_start, observations, prior);
  for (size_t k = 0; k < a->feature_of.size(); ++k) {
    if (!a->estimate.inlier[k]) a->match[a->feature_of[k]] = -1;
  }
}

std::optional<PosePrior> Tracker::Impl::PriorFor(const Prediction& prediction, double alpha) const {
  if (!prediction.from_dr || alpha <= 0) return std::nullopt;
  return PosePrior{prediction.T_WC, alpha * prediction.motion_cov.inverse()};
}

// Second stage: the rest of the local map, in small windows around the pose of the first.
void Tracker::Impl::SearchLocalMap(const FeatureFrame& frame, const std::optional<PosePrior>& prior,
                                   Association* a) {
  std::vector<LandmarkId> ids;
  for (const int m : a->match) {
    if (m >= 0) ids.push_back(a->candidates[m].point->id);
  }
  std::sort(ids.begin(), ids.end());
  std::vector<const MapPoint*> points;
  map_.CollectAround(ids, reference_, kLocalKeyframes, &points, &reference_);
  std::vector<Candidate> more;
  for (const MapPoint* point : points) {
    if (std::binary_search(ids.begin(), ids.end(), point->id)) continue;
    more.push_back({point, &point->descriptor, -1, kSecondStageRadius});
  }
  const int first = static_cast<int>(a->candidates.size());
  a->candidates.insert(a->candidates.end(), more.begin(), more.end());
  matcher_.Match(a->estimate.T_WC, more, first, frame, grid_,
                 {.max_distance = 80, .max_ratio = 0.85}, &a->match);
  Estimate(frame, a->estimate.T_WC, prior, a);
}

// Tracks from a prediction. False: vision does not carry the pose (report->reason says why).
bool Tracker::Impl::FollowMap(const FeatureFrame& frame, const Prediction& prediction,
                              FramePose* report, Association* a) {
  const Matrix6d search_cov = blind_cov_ + prediction.motion_cov;
  const bool recovering = tracked_.size() < static_cast<size_t>(kFewMatches);
  float radius = SearchRadius(search_cov);
  std::vector<const MapPoint*> near;
  const auto collect = [&](float r) {
    a->candidates.clear();
    for (const TrackedPoint& t : tracked_) {
      const MapPoint* point = map_.Find(t.id);
      if (point != nullptr) a->candidates.push_back({point, &t.descriptor, t.level, r});
    }
    for (const MapPoint* point : near) a->candidates.push_back({point, &point->descriptor, -1, r});
  };
  if (recovering) {
    KeyframeId nearest;
    map_.CollectNear(prediction.T_WC, kRecoveryKeyframes, &near, &nearest);
    if (nearest.valid()) reference_ = nearest;
    radius = std::max(radius, 10.0F);
    tracked_.clear();
  }
  // After a blind span the prior's mean is the drifted pose: it counts with that drift.
  Prediction start = prediction;
  if (recovering) start.motion_cov = search_cov;
  // A window that does not reach the true place still finds look-alikes: the share of inliers
  // tells.
  const auto trust = [&](const Association& found) {
    return found.estimate.num_inliers >= kFewMatches &&
           found.estimate.num_inliers >= kTrustedShare * found.num_first_stage;
  };
  Association best;
  for (int attempt = 0; attempt < kAttempts; ++attempt, radius = std::min(2 * radius, kMaxRadius)) {
    collect(radius);
    a->match.assign(frame.features.size(), -1);
    a->estimate = PoseEstimate();
    a->num_first_stage =
        matcher_.Match(prediction.T_WC, a->candidates, 0, frame, grid_, {}, &a->match).num_matched;
    if (a->num_first_stage >= config_.min_inliers) {
      const double q = Quality({report->num_detected, a->num_first_stage}, config_.dr_weight);
      Estimate(frame, prediction.T_WC,
               PriorFor(start, VariantScale(config_.variant, q, config_.dr_weight)), a);
    }
    if (attempt == 0 || a->estimate.num_inliers > best.estimate.num_inliers) best = *a;
    if (trust(best) || radius >= kMaxRadius) break;
  }
  *a = std::move(best);
  report->num_tracked = a->num_first_stage;
  report->q = Quality({report->num_detected, report->num_tracked}, config_.dr_weight);
  report->alpha =
      prediction.from_dr ? VariantScale(config_.variant, report->q, config_.dr_weight) : 0;
  if (a->num_first_stage < config_.min_inliers) {
    report->reason = report->num_detected < config_.min_inliers ? TrackingReason::kTooFewFeatures
                                                                : TrackingReason::kTooFewMatches;
    return false;
  }
  if (a->estimate.num_inliers >= config_.min_inliers / 2) {
    SearchLocalMap(frame, PriorFor(start, report->alpha), a);
  }
  if (a->estimate.num_inliers < config_.min_inliers * (recovering ? 2 : 1)) {
    report->reason = TrackingReason::kTooFewInliers;
    return false;
  }
  return true;
}

// Looks for the pose without a prediction. False: not found.
bool Tracker::Impl::FindAgain(const FeatureFrame& frame, Utime utime, FramePose* report,
                              Association* a) {
  std::vector<const MapPoint*> points;
  KeyframeId nearest;
  map_.CollectNear(T_WC_, kLocalKeyframes, &points, &nearest);
  const auto T_WC = Relocalize(camera_, scale_.factor, frame, points, config_.min_inliers,
                               static_cast<uint64_t>(utime.us));
  if (!T_WC) return false;
  reference_ = nearest;
  a->candidates.clear();
  for (const MapPoint* point : points)
    a->candidates.push_back({point, &point->descriptor, -1, 8.0F});
  a->match.assign(frame.features.size(), -1);
  a->num_first_stage =
      matcher_.Match(*T_WC, a->candidates, 0, frame, grid_, {}, &a->match).num_matched;
  Estimate(frame, *T_WC, std::nullopt, a);
  SearchLocalMap(frame, std::nullopt, a);
  if (a->estimate.num_inliers < kRelocalizedInliers) return false;
  report->num_tracked = a->num_first_stage;
  report->q = Quality({report->num_detected, report->num_tracked}, config_.dr_weight);
  report->alpha = 0;
  return true;
}

// Takes over the pose of an image that vision carries.
void Tracker::Impl::Accept(const Association& a, const FeatureFrame& frame,
                           const Prediction& prediction, FramePose* report) {
  const PoseEstimate& e = a.estimate;
  Matrix6d information = e.vision_information + e.prior_information;
  cov_ = information.inverse();
  if (e.prior_information.squaredNorm() > 0) {
    // Shares are compared in units of the DR noise, so that metres and radians can be added.
    const Matrix6d& unit = prediction.motion_cov;
    const double prior = (unit * e.prior_information).trace();
    report->dr_share = prior / (prior + (unit * e.vision_information).trace());
  }
  report->num_inliers = e.num_inliers;
  T_WC_ = e.T_WC;
  tracked_.clear();
  for (size_t i = 0; i < a.match.size(); ++i) {
    if (a.match[i] < 0) continue;
    tracked_.push_back(
        {a.candidates[a.match[i]].point->id, frame.descriptors[i], frame.features[i].level});
  }
  blind_cov_.setZero();
  placed_ = true;
}

bool Tracker::Impl::WantsKeyframe(Utime utime, const FeatureFrame& frame, const Association& a,
                                  bool vision) const {
  if (images_since_keyframe_ < 2) return false;
  KeyframeEvidence e;
  e.since_last = utime - keyframe_utime_;
  e.vision = vision;
  e.num_inliers = vision ? a.estimate.num_inliers : 0;
  e.reference_inliers = reference_inliers_;
  std::vector<float> depths;
  for (size_t i = 0; i < frame.features.size(); ++i) {
    if (!frame.features[i].has_depth()) continue;
    depths.push_back(frame.features[i].depth);
    const bool tracked = vision && a.match[i] >= 0;
    ++(tracked ? e.num_close_tracked : e.num_close_untracked);
  }
  if (!depths.empty()) {
    std::nth_element(depths.begin(), depths.begin() + depths.size() / 2, depths.end());
    e.median_depth_m = depths[depths.size() / 2];
  }
  e.translation_m = T_CkeyC_.translation().norm();
  e.rotation_rad = LogSO3(T_CkeyC_.rotation()).norm();
  return NeedsKeyframe(e, config_);
}

Keyframe Tracker::Impl::MakeKeyframe(Utime utime, const FeatureFrame& frame, const Association& a,
                                     const FramePose& report) {
  Keyframe k;
  k.id = next_keyframe_;
  k.utime = utime;
  k.T_WC = T_WC_;
  k.cov_T_WC = cov_;
  k.map_revision = map_.revision();
  k.previous = last_keyframe_;
  if (k.previous.valid()) k.dr = DrBetween(keyframe_utime_, utime);
  k.q = report.q;
  k.num_tracked = report.num_tracked;
  k.features = frame.features;
  k.descriptors = frame.descriptors;
  k.landmarks.resize(frame.features.size());
  for (size_t i = 0; i < frame.features.size(); ++i) {
    if (i < a.match.size() && a.match[i] >= 0) {
      k.landmarks[i] = a.candidates[a.match[i]].point->id;
    } else if (frame.features[i].has_depth()) {
      k.landmarks[i] = LandmarkId::From(k.id, static_cast<int>(i));
      tracked_.push_back({k.landmarks[i], frame.descriptors[i], frame.features[i].level});
    }
  }
  map_.AddKeyframe(k);
  next_keyframe_.value = k.id.value + 1;
  last_keyframe_ = reference_ = k.id;
  keyframe_utime_ = utime;
  T_CkeyC_ = SE3();
  reference_inliers_ = 0;
  images_since_keyframe_ = 0;
  return k;
}

// First image of this process: where does it stand?
void Tracker::Impl::Begin(const Prediction& prediction) {
  T_WC_ = prediction.T_WC;
  cov_ = Matrix6d::Identity() * 1e-12;
}

void Tracker::Impl::FillPose(FramePose* report) const {
  report->T_WB = T_WC_ * camera_.T_BC.inverse();
  const Matrix6d adj = camera_.T_BC.Adjoint();
  report->cov_T_WB = adj * cov_ * adj.transpose();
  report->map_revision = map_.revision();
  report->reference_keyframe = reference_;
  const auto T_WK = map_.KeyframePose(reference_);
  report->T_KC = T_WK ? T_WK->inverse() * T_WC_ : T_WC_;
  if (!dr_.empty()) {
    report->dr_seq = dr_.newest().seq;
    report->dr_reset_counter = dr_.newest().reset_counter;
  }
}

TrackerOutput Tracker::Impl::Push(const CameraFrame& frame) {
  TrackingReason problem = TrackingReason::kNone;
  if (extractor_.Extract(frame, &frame_) == FeatureExtractor::Outcome::kBadImage) {
    problem = TrackingReason::kBadImage;
    frame_ = FeatureFrame{};
  }
  return Track(frame.utime, frame.seq, frame_, problem);
}

TrackerOutput Tracker::Impl::Track(Utime utime, int64_t seq, const FeatureFrame& seen,
                                   TrackingReason image_problem) {
  TrackerOutput out;
  FramePose& report = out.pose;
  report.utime = utime;
  report.seq = seq;
  report.num_detected = seen.num_detected;
  if (has_image_ && utime <= utime_) {
    report.reason = TrackingReason::kTimeReversed;
    report.status = TrackingStatus::kLost;
    if (placed_) report.status = TrackingStatus::kDegraded;
    FillPose(&report);
    return out;
  }

  Prediction prediction = Predict(utime);
  if (!has_image_) Begin(prediction);
  if (!placed_ && hint_ && !map_.empty()) {
    prediction.T_WC = hint_->T_WB * camera_.T_BC;
    blind_cov_ = ToCamera(hint_->cov_T_WB);
    T_WC_ = prediction.T_WC;
  }
  FeatureFrame frame = seen;
  if (camera_.readout_s > 0 && has_image_) {
    const Vector6d motion = (T_WC_.inverse() * prediction.T_WC).Log();
    UndoRollingShutter(camera_, camera_.readout_s, motion.tail<3>() / (utime - utime_).seconds(),
                       &frame.features);
  }
  grid_.Build(frame.features, camera_.width, camera_.height);

  Association a;
  bool vision = false;
  report.reason = image_problem;
  if (image_problem != TrackingReason::kNone) {
    // Nothing to match; the prediction stands.
  } else if (!map_known_ || map_.empty()) {
    report.reason = TrackingReason::kNoMap;
  } else {
    vision = FollowMap(frame, prediction, &report, &a);
    if (!vision && (!prediction.from_dr || !placed_)) vision = FindAgain(frame, utime, &report, &a);
  }

  const SE3 T_WC_before = T_WC_;
  const Matrix6d cov_before = cov_;
  if (vision) {
    report.reason = TrackingReason::kNone;
    Accept(a, frame, prediction, &report);
    report.status = report.dr_share > 0.2 ? TrackingStatus::kDegraded : TrackingStatus::kTracking;
    const double dt = (utime - utime_).seconds();
    if (has_image_ && utime_ == last_vision_) {
      velocity_ = (T_WC_before.inverse() * T_WC_).Log() / dt;
    }
    last_vision_ = utime;
  } else {
    T_WC_ = prediction.T_WC;
    cov_ = Transport(cov_before, T_WC_before.inverse() * T_WC_) + prediction.motion_cov;
    if (has_image_) {
      blind_cov_ = Transport(blind_cov_, T_WC_before.inverse() * T_WC_) + prediction.motion_cov;
    }
    a.match.assign(frame.features.size(), -1);
    if (prediction.from_dr) {
      report.status = TrackingStatus::kDrOnly;
      report.dr_share = 1.0;
    } else {
      report.status = TrackingStatus::kLost;
    }
    if (!map_known_ || map_.empty()) report.status = TrackingStatus::kInitializing;
  }
  T_CkeyC_ = T_CkeyC_ * (T_WC_before.inverse() * T_WC_);
  if (!has_image_) T_CkeyC_ = SE3();
  ++images_since_keyframe_;
  if (vision && images_since_keyframe_ <= 5) {
    reference_inliers_ = std::max(reference_inliers_, report.num_inliers);
  }
  utime_ = utime;
  has_image_ = true;
  hint_.reset();

  bool keyframe = false;
  if (map_known_ && map_.empty()) {
    const auto with_depth = std::count_if(frame.features.begin(), frame.features.end(),
                                          [](const Feature& f) { return f.has_depth(); });
    keyframe = with_depth >= kMinInitialLandmarks;
    if (keyframe) {
      report.status = TrackingStatus::kTracking;
      report.reason = TrackingReason::kNone;
      last_vision_ = utime;
      placed_ = true;
    }
  } else if (vision || (placed_ && prediction.from_dr && DrInLocalBa(config_.variant))) {
    keyframe = WantsKeyframe(utime, frame, a, vision);
  }
  if (keyframe) out.keyframe = MakeKeyframe(utime, frame, a, report);
  FillPose(&report);
  return out;
}

bool Tracker::Impl::Push(const DrState& state) {
  return dr_.Push(state);
}

bool Tracker::Impl::Push(const MapUpdate& update) {
  const auto T_WK_before = map_.KeyframePose(reference_);
  if (!map_.Apply(update)) return false;
  if (update.snapshot) map_known_ = true;
  next_keyframe_.value = std::max(next_keyframe_.value, update.newest_keyframe.value + 1);

  // The pose follows the keyframe it is expressed in.
  if (T_WK_before) {
    SE3 T_KC = T_WK_before->inverse() * T_WC_;
    for (const KeyframeRemoval& removal : update.removed_keyframes) {
      if (removal.id == reference_) {
        reference_ = removal.parent;
        T_KC = removal.T_ParentC * T_KC;
      }
    }
    if (const auto T_WK = map_.KeyframePose(reference_)) T_WC_ = *T_WK * T_KC;
  }
  if (!update.merged_landmarks.empty()) {
    std::map<LandmarkId, LandmarkId> merged;
    for (const LandmarkMerge& m : update.merged_landmarks) merged[m.from] = m.into;
    for (TrackedPoint& t : tracked_) {
      // A landmark may be merged more than once; the bound guards against a circle in bad data.
      for (size_t i = 0; i < merged.size(); ++i) {
        const auto it = merged.find(t.id);
        if (it == merged.end()) break;
        t.id = it->second;
      }
    }
  }
  return true;
}

void Tracker::Impl::Push(const Pose& pose) {
  if (!placed_ && pose.has_map) hint_ = pose;
}

MapRequest Tracker::Impl::Request() const {
  MapRequest request;
  request.utime = utime_;
  request.has_guess = placed_ || hint_.has_value();
  request.T_WC_guess = hint_ ? hint_->T_WB * camera_.T_BC : T_WC_;
  return request;
}

Result<Tracker> Tracker::Create(const FrontendConfig& config, const CameraGeometry& geometry) {
  Result<FeatureExtractor> extractor = FeatureExtractor::Create(config.orb, geometry);
  if (!extractor) return extractor.error();
  return Tracker(std::make_unique<Impl>(config, geometry, std::move(*extractor)));
}

Tracker::Tracker(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Tracker::Tracker(Tracker&&) noexcept = default;
Tracker& Tracker::operator=(Tracker&&) noexcept = default;
Tracker::~Tracker() = default;

TrackerOutput Tracker::Push(const CameraFrame& frame) {
  return impl_->Push(frame);
}
TrackerOutput Tracker::Track(Utime utime, int64_t seq, const FeatureFrame& features) {
  return impl_->Track(utime, seq, features, TrackingReason::kNone);
}
bool Tracker::Push(const DrState& state) {
  return impl_->Push(state);
}
bool Tracker::Push(const MapUpdate& update) {
  return impl_->Push(update);
}
void Tracker::Push(const Pose& pose) {
  impl_->Push(pose);
}
MapRequest Tracker::Request() const {
  return impl_->Request();
}
bool Tracker::has_map() const {
  return impl_->has_map();
}

}  // namespace gw::frontend

#include "frontend/core/tracking/tracker.h"

#include <algorithm>
#include <map>
#include <utility>

#include "frontend/core/features/rolling_shutter.h"
#include "frontend/core/map/local_map.h"
#include "frontend/core/motion/motion_model.h"
#include "frontend/core/motion/pose_uncertainty.h"
#include "frontend/core/place/place_confirmation.h"
#include "frontend/core/place/recovery.h"
#include "frontend/core/place/view_change.h"
#include "frontend/core/tracking/keyframe_chain.h"
#include "frontend/core/tracking/pose_finder.h"

namespace gw::frontend {
namespace {

constexpr int kMinInitialLandmarks = 50;  // fewer do not carry the next image
// A correction larger than this is announced (status RECOVERING).
constexpr double kSnapTranslation = 0.02;  // m
constexpr double kSnapRotation = 0.0175;   // rad
// DR counts noticeably from this share of the pose's information.
constexpr double kNoticeableShare = 0.2;
// A POSE that is less sure than this does not know where it is itself.
constexpr double kHintSigma = 1.0;  // m

}  // namespace

class Tracker::Impl {
 public:
  Impl(const FrontendConfig& config, const CameraGeometry& geometry, FeatureExtractor extractor)
      : config_(config),
        camera_(geometry.rectified),
        extractor_(std::move(extractor)),
        finder_(config, camera_, {config.orb.scale_factor, config.orb.num_levels}),
        map_(camera_, {config.orb.scale_factor, config.orb.num_levels}),
        motion_(camera_, config),
        view_(camera_),
        chain_(config) {}

  TrackerOutput Push(const CameraFrame& frame);
  TrackerOutput Track(Utime utime, int64_t seq, const FeatureFrame& features,
                      TrackingReason image_problem);
  bool Push(const DrState& state) { return motion_.Push(state); }
  bool Push(const MapUpdate& update);
  void Push(const Pose& pose);
  void Push(const PlaceMatch& match);
  MapRequest Request() const;
  bool has_map() const { return map_known_; }

 private:
  bool VisionBroken() const { return !placed_ || utime_ != last_vision_; }
  bool map_there() const { return map_known_ && !map_.empty(); }
  FoundPose Find(const SE3& T_WC_predicted, const Motion& motion, Utime utime);
  FoundPose FindAnywhere(Utime utime);
  bool TakePlace(const Motion& motion, Utime utime, FoundPose* found);
  bool Believable(const FoundPose& found, const Motion& motion, const SE3& T_ab, bool hinted);
  PlaceEvidence Evidence(const FramePose& report, int num_inliers) const;
  void Accept(const FoundPose& found, const FeatureFrame& frame, const Motion& motion,
              const SE3& T_WC_predicted, FramePose* report);
  bool BeginsMap(const FeatureFrame& frame) const;
  bool ContinuesMap(bool vision, const Motion& motion) const;
  Keyframe MakeKeyframe(const FeatureFrame& frame, const FoundPose& found, const FramePose& report);
  void FillPose(FramePose* report) const;
  void FillMotion(FramePose* report);
  void ConsiderPlace(const FeatureFrame& frame, const PlaceEvidence& evidence, bool hinted,
                     TrackerOutput* out);

  FrontendConfig config_;
  RectifiedCamera camera_;
  FeatureExtractor extractor_;
  PoseFinder finder_;
  LocalMap map_;
  MotionModel motion_;
  FeatureFrame frame_;
  ViewChange view_;
  bool other_view_ = false;  // of the newest image

  bool map_known_ = false;   // a snapshot has come
  bool map_frozen_ = false;  // the back-end takes in no keyframes: none are made
  bool has_image_ = false;
  bool placed_ = false;  // the pose refers to the map, not only to the start of this process
  Utime utime_;          // of the last image
  SE3 T_WC_;
  PoseUncertainty uncertainty_;  // of T_WC_
  Utime last_vision_;            // the last image whose pose came from vision
  Recovery recovery_;
  std::vector<TrackedPoint> tracked_;
  std::optional<Pose> hint_;
  PlaceConfirmation place_;
  std::optional<PlaceConfirmation::Confirmed> confirmed_;  // to be tracked from at the next image
  bool claims_place_ = false;  // the newest image's pose; false: it may be anywhere

  KeyframeId reference_;  // keyframe the pose is expressed in
  KeyframeChain chain_;
};

FoundPose Tracker::Impl::Find(const SE3& T_WC_predicted, const Motion& motion, Utime utime) {
  PosePrediction prediction;
  prediction.T_WC = T_WC_predicted;
  prediction.search_cov = motion.weight_cov;
  prediction.has_prior = motion.from_dr;
  prediction.weight_cov = motion.weight_cov;
  prediction.vision_broken = VisionBroken();
  if (prediction.vision_broken) {
    // The mean of the prior is the drifted pose: it counts with that drift, and no more.
    prediction.search_cov += uncertainty_.cov();
    prediction.weight_cov = prediction.search_cov;
  }
  if (AdaptsAlpha(config_.variant)) {
    prediction.honest_cov =
        prediction.vision_broken ? prediction.search_cov : motion.noise.Covariance();
  }
  FoundPose found = finder_.Follow(prediction, tracked_, reference_, &map_);
  if (!found.found && !motion.from_dr) {
    FoundPose again = finder_.FindAgain(T_WC_, static_cast<uint64_t>(utime.us), &map_);
    if (again.found) return again;
  }
  return found;
}

// Where this tracker has no place yet. With dead reckoning, answers of the back-end are compared;
// a look-alike near the origin of W would pass for the place here.
FoundPose Tracker::Impl::FindAnywhere(Utime utime) {
  FoundPose found;
  if (!motion_.OdometryPose(utime)) {
    found = finder_.FindAgain(T_WC_, static_cast<uint64_t>(utime.us), &map_);
  }
  if (!found.found) found.reason = TrackingReason::kPlaceUnknown;
  return found;
}

// Tracks the image from the confirmed place, which is taken over when the image is seen there. Call
// after uncertainty_ was predicted.
bool Tracker::Impl::TakePlace(const Motion& motion, Utime utime, FoundPose* found) {
  const auto T_OC = motion_.OdometryPose(utime_);
  if (!T_OC) return false;
  const SE3 T_WC = confirmed_->T_WO * *T_OC;  // of the last image
  const SE3 T_WC_predicted = T_WC * motion.T_ab;
  PoseUncertainty uncertainty;
  uncertainty.Reset(confirmed_->cov_T_WC);
  uncertainty.Predict(motion.T_ab, motion.noise, utime - utime_);
  PosePrediction prediction;
  prediction.T_WC = T_WC_predicted;
  prediction.search_cov = uncertainty.cov() + motion.weight_cov;
  prediction.has_prior = motion.from_dr;
  prediction.weight_cov = prediction.honest_cov = prediction.search_cov;
  prediction.vision_broken = true;
  *found = finder_.Follow(prediction, {}, {}, &map_);
  if (!found->found) return false;
  const PoseEstimate& e = found->estimate;
  if (!SamePlace(T_WC_predicted.inverse() * e.T_WC)) return false;
  // Dead reckoning does not lead from the last keyframe to here.
  const bool carried = place_.in_doubt() || !PosesAgree(T_WC_ * motion.T_ab, e.T_WC,
                                                        uncertainty_.cov() + motion.weight_cov +
                                                            VisionCovariance(e.vision_information));
  if (carried) chain_.Break();
  T_WC_ = T_WC;
  uncertainty_ = uncertainty;
  placed_ = true;
  return true;
}

// Of a pose that vision finds after it was broken. T_ab: motion since the last image. Call after
// uncertainty_ was predicted.
bool Tracker::Impl::Believable(const FoundPose& found, const Motion& motion, const SE3& T_ab,
                               bool hinted) {
  const Matrix6d cov = VisionCovariance(found.estimate.vision_information);
  std::optional<Recovery::Expectation> expected;
  if (placed_ || hinted) {
    expected = Recovery::Expectation{T_WC_ * motion.T_ab, uncertainty_.cov() + motion.weight_cov,
                                     place_.in_doubt()};
  }
  const Recovery::Verdict verdict = recovery_.Judge(
      {found.estimate.T_WC, cov, found.estimate.num_inliers, T_ab, motion.weight_cov}, expected);
  // Dead reckoning does not lead from the last keyframe to here.
  if (verdict == Recovery::Verdict::kElsewhere) chain_.Break();
  return verdict != Recovery::Verdict::kWait;
}

// Takes over the pose of an image that vision carries.
void Tracker::Impl::Accept(const FoundPose& found, const FeatureFrame& frame, const Motion& motion,
                           const SE3& T_WC_predicted, FramePose* report) {
  const PoseEstimate& e = found.estimate;
  if (e.prior_information.squaredNorm() > 0) {
    // Shares are compared in units of the DR noise, so that metres and radians can be added.
    const Matrix6d& unit = motion.weight_cov;
    const double prior = (unit * e.prior_information).trace();
    report->dr_share = prior / (prior + (unit * e.vision_information).trace());
  }
  report->num_inliers = e.num_inliers;
  report->reason = TrackingReason::kNone;
  report->status =
      report->dr_share > kNoticeableShare ? TrackingStatus::kDegraded : TrackingStatus::kTracking;
  if (VisionBroken() && placed_) {
    const SE3 snap = T_WC_predicted.inverse() * e.T_WC;
    if (snap.translation().norm() > kSnapTranslation ||
        LogSO3(snap.rotation()).norm() > kSnapRotation) {
      report->status = TrackingStatus::kRecovering;
    }
  }
  uncertainty_.Update(e.vision_information, e.prior_information);
  T_WC_ = e.T_WC;
  reference_ = found.reference;
  tracked_.clear();
  for (size_t i = 0; i < found.landmarks.size(); ++i) {
    if (!found.landmarks[i].valid()) continue;
    tracked_.push_back({found.landmarks[i], frame.descriptors[i], frame.features[i].level});
  }
  recovery_.Reset();
  placed_ = true;
}

// There is no map yet, and this image shows enough to begin it.
bool Tracker::Impl::BeginsMap(const FeatureFrame& frame) const {
  if (map_frozen_ || !map_known_ || !map_.empty()) return false;
  const auto with_depth = std::count_if(frame.features.begin(), frame.features.end(),
                                        [](const Feature& f) { return f.has_depth(); });
  return with_depth >= kMinInitialLandmarks;
}

// An image may become a keyframe when it is known where it was taken, by vision or dead reckoning.
bool Tracker::Impl::ContinuesMap(bool vision, const Motion& motion) const {
  if (map_frozen_ || (map_known_ && map_.empty()) || place_.in_doubt()) return false;
  return vision || (placed_ && motion.from_dr && DrInLocalBa(config_.variant));
}

Keyframe Tracker::Impl::MakeKeyframe(const FeatureFrame& frame, const FoundPose& found,
                                     const FramePose& report) {
  Keyframe k =
      chain_.Make({frame, found, report, T_WC_, uncertainty_.cov(), map_.revision()}, motion_);
  for (size_t i = 0; i < k.landmarks.size(); ++i) {
    if (k.landmarks[i] != LandmarkId::From(k.id, static_cast<int>(i))) continue;
    tracked_.push_back({k.landmarks[i], frame.descriptors[i], frame.features[i].level});
  }
  map_.AddKeyframe(k);
  reference_ = k.id;
  return k;
}

void Tracker::Impl::FillMotion(FramePose* report) {
  const auto motion = uncertainty_.Remember(report->utime, T_WC_, FramePose::kMotionSpan);
  if (!motion) return;
  const Matrix6d adj = camera_.T_BC.Adjoint();
  report->motion_us = motion->length.us;
  report->cov_motion = adj * motion->cov * adj.transpose();
}

void Tracker::Impl::FillPose(FramePose* report) const {
  report->T_WB = T_WC_ * camera_.T_BC.inverse();
  const Matrix6d adj = camera_.T_BC.Adjoint();
  const Matrix6d cov = claims_place_ ? uncertainty_.cov() : CovarianceOfNoIdea();
  report->cov_T_WB = adj * cov * adj.transpose();
  report->map_revision = map_.revision();
  report->reference_keyframe = reference_;
  const auto T_WK = map_.KeyframePose(reference_);
  report->T_KC = T_WK ? T_WK->inverse() * T_WC_ : T_WC_;
  if (const DrState* dr = motion_.newest_dr()) {
    report->dr_seq = dr->seq;
    report->dr_reset_counter = dr->reset_counter;
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
    report.status = placed_ ? TrackingStatus::kDegraded : TrackingStatus::kLost;
    FillPose(&report);
    return out;
  }

  Motion motion;
  if (has_image_) {
    motion = motion_.Between(utime_, utime);
    uncertainty_.Predict(motion.T_ab, motion.noise, utime - utime_);
  } else {
    T_WC_ = motion_.FirstPose(utime);
    uncertainty_.Reset(Matrix6d::Identity() * 1e-12);  // by definition
  }
  const SE3 T_ab = motion.T_ab;
  const bool hinted = !placed_ && hint_ && !map_.empty();
  if (hinted) {
    // From where POSE of the DR process says that the body was, in place of the last image's pose.
    T_WC_ = hint_->T_WB * camera_.T_BC;
    motion.T_ab = SE3();
    const Matrix6d to_camera = camera_.T_BC.inverse().Adjoint();
    uncertainty_.Reset(to_camera * hint_->cov_T_WB * to_camera.transpose());
  }

  FeatureFrame corrected;
  const FeatureFrame* frame = &seen;
  if (camera_.readout_s > 0 && has_image_) {
    corrected = seen;
    UndoRollingShutter(camera_, camera_.readout_s,
                       T_ab.Log().tail<3>() / (utime - utime_).seconds(), &corrected.features);
    frame = &corrected;
  }

  FoundPose found;
  report.reason = image_problem;
  bool snapped = false;
  if (image_problem == TrackingReason::kNone) {
    report.reason = TrackingReason::kNoMap;
    if (map_there()) {
      finder_.SetImage(frame);
      snapped = confirmed_ && TakePlace(motion, utime, &found);
      confirmed_.reset();
      if (!snapped) {
        found = placed_ || hinted ? Find(T_WC_ * motion.T_ab, motion, utime) : FindAnywhere(utime);
      }
      report.num_tracked = found.num_tracked;
      report.q = found.q;
      report.alpha = motion.from_dr ? found.scale.rotation : 0;
      report.reason = found.reason;
    }
  }
  // Many inliers answer the question; else the images are compared.
  const std::optional<SE3> T_OC = motion_.OdometryPose(utime);
  const bool weak =
      VisionBroken() || !found.found || found.estimate.num_inliers < PlaceConfirmation::kByChance;
  other_view_ = weak && view_.Changed(utime, *frame, T_OC);
  view_.Remember(utime, *frame, T_OC);

  const SE3 T_WC_before = T_WC_;
  const SE3 T_WC_predicted = T_WC_ * motion.T_ab;
  bool vision = found.found;
  if (vision && !snapped) {
    // What vision finds after it was broken has to be believed; without dead reckoning there is
    // nothing to hold against it, but that the place is in doubt or not known.
    const bool judged = VisionBroken() && (motion.from_dr || !placed_ || place_.in_doubt());
    vision = judged ? Believable(found, motion, T_ab, hinted)
                    : !place_.Contradicts(Evidence(report, found.estimate.num_inliers));
    if (!vision) report.reason = TrackingReason::kPoseJump;
  }
  const bool unconfirmed = found.found && !vision;

  if (vision) {
    const bool in_a_row = !VisionBroken();
    Accept(found, *frame, motion, T_WC_predicted, &report);
    if (has_image_) {
      motion_.Observe(T_WC_before.inverse() * T_WC_, motion, utime_, utime,
                      in_a_row && VisionMayJudgeDr(report));
    }
    last_vision_ = utime;
  } else {
    found = FoundPose{};
    if (!unconfirmed) recovery_.Reset();
    T_WC_ = T_WC_predicted;
    motion_.ObserveNothing();
    report.dr_share = motion.from_dr ? 1.0 : 0.0;
    report.status = unconfirmed      ? TrackingStatus::kRecovering
                    : motion.from_dr ? TrackingStatus::kDrOnly
                                     : TrackingStatus::kLost;
    if (!map_there()) report.status = TrackingStatus::kInitializing;
  }
  if (snapped) report.status = TrackingStatus::kRecovering;
  PlaceEvidence evidence = Evidence(report, vision ? report.num_inliers : 0);
  evidence.relocalised = snapped;
  ConsiderPlace(*frame, evidence, hinted, &out);
  chain_.Observe(has_image_ ? T_WC_before.inverse() * T_WC_ : SE3(),
                 !vision && report.num_detected >= config_.keyframe_min_close);
  utime_ = utime;
  has_image_ = true;
  hint_.reset();

  if (BeginsMap(*frame)) {
    report.status = TrackingStatus::kTracking;
    report.reason = TrackingReason::kNone;
    last_vision_ = utime;
    placed_ = true;
    out.keyframe = MakeKeyframe(*frame, found, report);
  } else if (ContinuesMap(vision, motion) &&
             chain_.WantsNext(utime, *frame, found, map_.NumLandmarks(reference_))) {
    out.keyframe = MakeKeyframe(*frame, found, report);
  }
  FillPose(&report);
  FillMotion(&report);
  return out;
}

// What an image tells of the place; num_inliers: of the pose from vision, 0 when it has none.
PlaceEvidence Tracker::Impl::Evidence(const FramePose& report, int num_inliers) const {
  PlaceEvidence e;
  e.utime = report.utime;
  e.placed = placed_;
  e.map_there = map_there();
  e.num_inliers = num_inliers;
  e.num_detected = report.num_detected;
  e.other_view = other_view_;
  e.T_OC = motion_.OdometryPose(report.utime);
  return e;
}

// Doubt and questions about where this image was taken. Call when its pose is decided, before a
// keyframe is made of it.
void Tracker::Impl::ConsiderPlace(const FeatureFrame& frame, const PlaceEvidence& evidence,
                                  bool hinted, TrackerOutput* out) {
  FramePose& report = out->pose;
  if (place_.Observe(evidence)) {
    out->query = PlaceQuery{report.utime, 0, frame.features, frame.descriptors};
  }
  // An empty map begins where this tracker is.
  const bool known = placed_ || hinted || (map_known_ && map_.empty());
  claims_place_ = known && !place_.in_doubt();
  if (claims_place_ || !evidence.map_there) return;
  report.status = TrackingStatus::kRecovering;
  report.reason = known ? TrackingReason::kPoseJump : TrackingReason::kPlaceUnknown;
}

bool Tracker::Impl::Push(const MapUpdate& update) {
  const auto T_WK_before = map_.KeyframePose(reference_);
  if (!map_.Apply(update)) return false;
  if (update.snapshot) {
    map_known_ = true;
    map_frozen_ = update.frozen;
  }
  chain_.Skip(update.newest_keyframe);

  // The pose follows the keyframe it is expressed in.
  if (T_WK_before) {
    const SE3 T_WC_before = T_WC_;
    SE3 T_KC = T_WK_before->inverse() * T_WC_;
    for (const KeyframeRemoval& removal : update.removed_keyframes) {
      if (removal.id == reference_) {
        reference_ = removal.parent;
        T_KC = removal.T_ParentC * T_KC;
      }
    }
    if (const auto T_WK = map_.KeyframePose(reference_)) T_WC_ = *T_WK * T_KC;
    uncertainty_.Shift((T_WC_before.inverse() * T_WC_).Log());
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
  const double variance = pose.cov_T_WB.diagonal().head<3>().maxCoeff();
  if (!placed_ && pose.has_map && variance < kHintSigma * kHintSigma) hint_ = pose;
}

void Tracker::Impl::Push(const PlaceMatch& match) {
  const auto T_OC = motion_.OdometryPose(match.utime);
  if (!T_OC) return;
  if (const auto confirmed = place_.Take(match, *T_OC)) confirmed_ = confirmed;
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
void Tracker::Push(const PlaceMatch& match) {
  impl_->Push(match);
}
MapRequest Tracker::Request() const {
  return impl_->Request();
}
bool Tracker::has_map() const {
  return impl_->has_map();
}

}  // namespace gw::frontend

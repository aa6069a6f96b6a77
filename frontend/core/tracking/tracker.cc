#include "frontend/core/tracking/tracker.h"

#include <algorithm>
#include <utility>

#include "common/core/clock_watch.h"
#include "common/good_weights/camera_motion.h"
#include "common/good_weights/quality.h"
#include "common/good_weights/vision_noise.h"
#include "frontend/core/features/image_cleaner.h"
#include "frontend/core/features/view_watch.h"
#include "frontend/core/map/local_map.h"
#include "frontend/core/motion/motion_model.h"
#include "frontend/core/place/place_watch.h"
#include "frontend/core/place/recovery.h"
#include "frontend/core/tracking/camera_track.h"
#include "frontend/core/tracking/frame_detail.h"
#include "frontend/core/tracking/image_intake.h"
#include "frontend/core/tracking/map_growth.h"
#include "frontend/core/tracking/pose_judge.h"
#include "frontend/core/tracking/pose_search.h"
#include "frontend/core/tracking/tracking_state.h"
#include "frontend/core/tracking/witnesses.h"

namespace gw::frontend {
namespace {

// A correction larger than this is announced (status RECOVERING).
constexpr double kSnapTranslation = 0.02;  // m
constexpr double kSnapRotation = 0.0175;   // rad
// Quality from which a pose may contradict dead reckoning: half of what there is to be seen is.
constexpr double kSureQuality = 0.5;
// How far the robot may go in the few images that it takes to see that the clock was set back.
constexpr double kMovedMeanwhile = 0.3;   // m
constexpr double kTurnedMeanwhile = 0.3;  // rad

// Why an image is not used.
TrackingReason ProblemOf(FeatureExtractor::Outcome outcome) {
  switch (outcome) {
    case FeatureExtractor::Outcome::kBadImage:
      return TrackingReason::kBadImage;
    case FeatureExtractor::Outcome::kOneEyeTwice:
      return TrackingReason::kOneEyeTwice;
    case FeatureExtractor::Outcome::kEyesExchanged:
      return TrackingReason::kEyesExchanged;
    case FeatureExtractor::Outcome::kOk:
    case FeatureExtractor::Outcome::kMissingDepth:
      break;
  }
  return TrackingReason::kNone;
}

}  // namespace

class Tracker::Impl {
 public:
  Impl(const FrontendConfig& config, const CameraGeometry& geometry, FeatureExtractor extractor)
      : config_(config),
        camera_(geometry.rectified),
        extractor_(std::move(extractor)),
        map_(camera_, Pyramid(config.orb.scale_factor, config.orb.num_levels)),
        motion_(camera_, geometry.calibration.imu, config),
        cleaner_(geometry, Pyramid(config.orb.scale_factor, config.orb.num_levels)),
        view_(camera_.width),
        place_(camera_, Departs(Departure::kRecovery)),
        track_(config),
        parts_{&motion_, &cleaner_, &map_, &witnesses_, &place_, &track_},
        intake_(config, parts_),
        search_(config, camera_, parts_),
        judge_(config, parts_),
        growth_(config, parts_) {}

  TrackerOutput Push(const CameraFrame& frame);
  TrackerOutput Track(Utime utime, int64_t seq, const FeatureFrame& features,
                      TrackingReason image_problem);
  bool Push(const DrState& state) { return motion_.Push(state); }
  bool Push(const MapUpdate& update);
  void Push(const Pose& pose);
  void Push(const PlaceMatch& match);
  MapRequest Request() const;
  bool has_map() const { return map_.known(); }
  DrConstantFault dr_fault() const { return motion_.dr_fault(); }
  LengthFault length_fault() const { return intake_.length_fault(); }
  ViewFault view_fault() const {
    const ViewFault of_depth = cleaner_.depth_fault();
    return of_depth != ViewFault::kNone ? of_depth : view_.fault();
  }

 private:
  bool Departs(Departure d) const { return config_.dr_weight.Departs(d); }

  TrackerOutput Refuse(TrackerOutput out) const;
  void Restart(Utime utime);
  TrackedImage Predict(Utime utime);
  void ExpectWhatWasSeen(const FoundPose& found);
  void Accept(const TrackedImage& image, FramePose* report, ImageOutcome* outcome);
  void GoOnWithout(const TrackedImage& image, FramePose* report, const ImageOutcome& outcome);
  void Judge(TrackedImage* image, TrackerOutput* out);
  void CompareViews(const TrackedImage& image);
  MotionModel::Seen Seen(const TrackedImage& image, const SE3& T_ab, const FramePose& report,
                         bool carried) const;
  void ConsiderPlace(const TrackedImage& image, TrackerOutput* out, ImageOutcome* outcome);
  void BeginPiece(ImageOutcome* outcome);
  void FillPose(FramePose* report) const;
  void FillMotion(FramePose* report);

  FrontendConfig config_;
  RectifiedCamera camera_;
  FeatureExtractor extractor_;
  LocalMap map_;
  MotionModel motion_;
  FeatureFrame frame_;
  ImageCleaner cleaner_;
  ViewWatch view_;
  PlaceWatch place_;
  CameraTrack track_;

  ClockWatch clock_;
  Witnesses witnesses_{&motion_, &track_.anchors};
  std::optional<Pose> hint_;
  bool joined_ = false;        // the piece in use became part of another: the next pose jumps
  bool claims_place_ = false;  // the newest image's pose; false: it may be anywhere
  TrackerParts parts_;
  ImageIntake intake_;
  PoseSearch search_;
  PoseJudge judge_;
  MapGrowth growth_;
};

// What was found in the image before tells where the view is clear.
void Tracker::Impl::ExpectWhatWasSeen(const FoundPose& found) {
  std::vector<LandmarkId> again = found.landmarks;
  std::sort(again.begin(), again.end());
  const SE3 T_CW = found.estimate.T_WC.inverse();
  for (const TrackedPoint& point : track_.points) {
    const auto uv = map_.PixelOf(point.id, T_CW);
    if (uv) view_.Expect(uv->x(), std::binary_search(again.begin(), again.end(), point.id));
  }
}

// Takes over the pose of an image that vision carries.
void Tracker::Impl::Accept(const TrackedImage& image, FramePose* report, ImageOutcome* outcome) {
  const FoundPose& found = image.found;
  const PoseEstimate& e = found.estimate;
  if (e.prior_information.squaredNorm() > 0) {
    // Shares are compared in units of the DR noise, so that metres and radians can be added.
    const Matrix6d& unit = image.motion.weight_cov;
    const double prior = (unit * e.prior_information).trace();
    report->dr_share = prior / (prior + (unit * e.vision_information).trace());
  }
  report->num_inliers = e.num_inliers;
  report->reason = TrackingReason::kNone;
  const SE3 correction = image.T_WC_predicted.inverse() * e.T_WC;
  outcome->corrected = image.snapped || (track_.state == TrackingState::kBlind &&
                                         (correction.translation().norm() > kSnapTranslation ||
                                          LogSO3(correction.rotation()).norm() > kSnapRotation));
  ExpectWhatWasSeen(found);
  intake_.JudgeDepth(image);
  track_.Take(found, *image.frame, map_);
  witnesses_.Learn(image.of_dr(), image.agreed, found);
  judge_.Forget();
}

// Without a pose from vision that is believed.
void Tracker::Impl::GoOnWithout(const TrackedImage& image, FramePose* report,
                                const ImageOutcome& outcome) {
  if (outcome.unconfirmed) {
    report->reason = TrackingReason::kPoseJump;
  } else {
    judge_.Forget();
  }
  motion_.GoOn(track_.utime, image.utime, image.motion);
  track_.GoOn(image.motion.T_ab, image.T_WC_predicted);
  report->dr_share = image.motion.from_dr ? 1.0 : 0.0;
}

// The piece begins where dead reckoning has led.
void Tracker::Impl::BeginPiece(ImageOutcome* outcome) {
  outcome->begins_piece = true;
  track_.BeginPiece(&map_);
  witnesses_.Forget();
  judge_.Forget();
  place_.BeginPiece();
}

void Tracker::Impl::FillMotion(FramePose* report) {
  const auto motion =
      track_.uncertainty.Remember(report->utime, track_.T_WC, FramePose::kMotionSpan);
  if (!motion) return;
  const Matrix6d adj = camera_.T_BC.Adjoint();
  report->motion_us = motion->length.us;
  report->cov_motion = adj * motion->cov * adj.transpose();
}

void Tracker::Impl::FillPose(FramePose* report) const {
  report->T_WB = track_.T_WC * camera_.T_BC.inverse();
  const Matrix6d adj = camera_.T_BC.Adjoint();
  const Matrix6d cov = claims_place_ ? track_.cov() : CovarianceOfNoIdea();
  report->cov_T_WB = adj * cov * adj.transpose();
  report->map_revision = map_.revision();
  if (const auto T_WK = map_.KeyframePose(track_.reference)) {
    report->reference_keyframe = track_.reference;
    report->T_KC = T_WK->inverse() * track_.T_WC;
  } else {
    report->T_KC = track_.T_WC;
  }
  if (const DrState* dr = motion_.newest_dr()) {
    report->dr_seq = dr->seq;
    report->dr_reset_counter = dr->reset_counter;
  }
}

TrackerOutput Tracker::Impl::Push(const CameraFrame& frame) {
  const FeatureExtractor::Outcome outcome = extractor_.Extract(frame, &frame_);
  const bool complete = outcome == FeatureExtractor::Outcome::kOk;
  cleaner_.depth_sync().Push(frame.utime, complete ? frame.depth : ImageView());
  TrackingReason problem = ProblemOf(outcome);
  // While the robot turns, what an eye sees too late may well lie on the other side.
  const bool late = problem == TrackingReason::kEyesExchanged && cleaner_.eyes_apart();
  if (late) problem = TrackingReason::kNone;
  if (problem != TrackingReason::kNone) frame_ = FeatureFrame();
  return Track(frame.utime, frame.seq, frame_, problem);
}

// Answers an image that is not newer than the one before, and is not used.
TrackerOutput Tracker::Impl::Refuse(TrackerOutput out) const {
  out.pose.reason = TrackingReason::kTimeReversed;
  out.pose.status = StatusOf(track_.state, {.time_reversed = true});
  FillPose(&out.pose);
  return out;
}

// The clock was set back: the time of the last image is made to be just before this one. How much
// time passed since nobody knows; the robot is looked for around where it was, as after a blind
// span.
void Tracker::Impl::Restart(Utime utime) {
  if (track_.placed()) track_.state = TrackingState::kBlind;
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(kMovedMeanwhile), Eigen::Vector3d::Constant(kTurnedMeanwhile);
  const Matrix6d moved = sigma.cwiseAbs2().asDiagonal();
  const Matrix6d cov = track_.uncertainty.cov() + moved;
  track_.uncertainty = PoseUncertainty();
  track_.uncertainty.Reset(cov);
  track_.utime = utime - DurationUs{1};
  place_.Restart();
  judge_.Forget();
  track_.anchors.Clear();
  witnesses_.Clear();
  motion_.Restart();
  track_.chain.Restart(utime);
}

// Where the image should have been taken, and how sure that is.
TrackedImage Tracker::Impl::Predict(Utime utime) {
  TrackedImage image;
  image.utime = utime;
  if (track_.state == TrackingState::kStart) {
    track_.T_WC = motion_.FirstPose(utime);
    track_.BeginFrame();
  } else {
    image.motion = motion_.Between(track_.utime, utime);
    track_.uncertainty.Predict(image.motion.T_ab, image.motion.noise, utime - track_.utime);
  }
  image.T_ab = image.motion.T_ab;
  image.hinted = !track_.placed() && hint_ && !map_.empty();
  if (image.hinted) {
    // From where POSE of the DR process says that the body was, in place of the last image's pose.
    track_.T_WC = hint_->T_WB * camera_.T_BC;
    image.motion.T_ab = SE3();
    track_.uncertainty.Reset(InCamera(hint_->cov_T_WB, camera_.T_BC));
  }
  image.T_WC_before = track_.T_WC;
  image.T_WC_predicted = track_.T_WC * image.motion.T_ab;
  return image;
}

// Finds out whether the image shows the scene of the one before. Many inliers answer the question;
// else the images are compared.
void Tracker::Impl::CompareViews(const TrackedImage& image) {
  const std::optional<SE3> T_OC = motion_.OdometryPose(image.utime);
  const bool weak = track_.vision_broken() || !image.found.found ||
                    image.found.estimate.num_inliers < PlaceConfirmation::kWellTracked;
  place_.CompareViews(*image.frame, T_OC, weak);
}

TrackerOutput Tracker::Impl::Track(Utime utime, int64_t seq, const FeatureFrame& features,
                                   TrackingReason image_problem) {
  TrackerOutput out;
  FramePose& report = out.pose;
  report.utime = utime;
  report.seq = seq;
  out.detail.utime = utime;
  out.detail.seq = seq;
  const ClockWatch::Verdict order = clock_.Judge(utime);
  report.num_detected = features.num_detected;
  if (order == ClockWatch::Verdict::kLate) return Refuse(std::move(out));
  if (order == ClockWatch::Verdict::kSetBack) Restart(utime);

  if (intake_.CorrectLengths()) judge_.Forget();
  const FeatureFrame& seen = intake_.InMetres(features);
  const FeatureFrame* const of_world = intake_.LeaveOutFixed(utime, seen);
  report.num_detected = of_world->num_detected;
  TrackedImage image = Predict(utime);
  image.frame = image.of_world = of_world;
  if (track_.state != TrackingState::kStart) {
    if (Departs(Departure::kLooksHealthy))
      cleaner_.JudgeEyes(seen, image.T_ab, image.utime - track_.utime);
    image.frame = cleaner_.Correct(of_world, image.T_ab, image.utime - track_.utime);
  }
  report.reason = image_problem;
  if (image_problem == TrackingReason::kNone) {
    report.reason = TrackingReason::kNoMap;
    if (map_.there()) {
      search_.Locate(&image);
      report.num_tracked = image.found.num_tracked;
      report.q = image.found.q;
      report.alpha = image.motion.from_dr ? image.found.scale.rotation : 0;
      report.reason = image.found.reason;
    }
  }
  CompareViews(image);
  Judge(&image, &out);
  if (image_problem == TrackingReason::kNone) view_.Observe(utime, features);
  FillPose(&report);
  FillMotion(&report);
  return out;
}

// From what was found to a pose, a status, and perhaps a keyframe.
void Tracker::Impl::Judge(TrackedImage* image, TrackerOutput* out) {
  FramePose& report = out->pose;
  ImageOutcome outcome;
  outcome.map_there = map_.there();
  outcome.from_dr = image->motion.from_dr;
  outcome.vision = image->found.found && judge_.Believes(*image);
  outcome.unconfirmed = image->found.found && !outcome.vision;
  outcome.begins_map = growth_.BeginsMap(*image->frame);
  out->detail = ExplainFrame({.utime = report.utime,
                              .seq = report.seq,
                              .frame = image->frame,
                              .found = &image->found,
                              .vision = outcome.vision,
                              .from_dr = image->motion.from_dr,
                              .dr_trusted = motion_.dr_trusted(),
                              .T_BC = camera_.T_BC},
                             config_.dr_weight);
  if (outcome.vision) {
    Accept(*image, &report, &outcome);
  } else {
    GoOnWithout(*image, &report, outcome);
    image->found = FoundPose{};
  }
  outcome.corrected |= std::exchange(joined_, false);
  outcome.q = report.q;
  outcome.dr_share = report.dr_share;
  ConsiderPlace(*image, out, &outcome);
  const bool carried = StatusOf(track_.state, outcome) == TrackingStatus::kTracking;
  // A constant that is taken out of dead reckoning may as well be one of vision: of its scale.
  outcome.contradicted = !motion_.dr_trusted() || !motion_.dr_fault().empty() ||
                         length_fault().found() || cleaner_.fixed_prevails() ||
                         cleaner_.depth_spoilt();
  report.status = StatusOf(track_.state, outcome);
  if (outcome.begins_map) report.reason = TrackingReason::kNone;
  if (cleaner_.depth_spoilt()) report.reason = TrackingReason::kEyesApart;
  if (cleaner_.fixed_prevails()) report.reason = TrackingReason::kFixedInImage;
  if (report.reason == TrackingReason::kNone && !motion_.dr_trusted()) {
    report.reason = TrackingReason::kDrContradictsVision;
  }

  const bool first = track_.state == TrackingState::kStart;
  const SE3 T_ab = image->T_WC_before.inverse() * track_.T_WC;
  if (!outcome.vision || witnesses_.Refuted(image->utime)) {
    motion_.ObserveNothing();
  } else if (!first) {
    motion_.Observe(Seen(*image, T_ab, report, carried), image->motion);
  }
  track_.chain.Observe(first ? SE3() : T_ab,
                       !outcome.vision && report.num_detected >= config_.keyframe_min_close);
  track_.state = NextState(track_.state, outcome);
  track_.utime = image->utime;
  track_.RememberAnchor(motion_);
  hint_.reset();
  const bool due = !outcome.begins_piece && growth_.IsDue(*image, outcome.vision);
  if (outcome.begins_map || outcome.begins_piece || due) {
    if (config_.matching != Matching::kAll) search_.Complete(&image->found);
    out->keyframe = growth_.Make(*image, report);
    track_.KeyframeMade(out->keyframe->id);
    MarkNewLandmarks(*out->keyframe, &out->detail);
  }
}

// What vision measured since the image before. carried: vision carries this pose, whether dead
// reckoning agrees or not.
MotionModel::Seen Tracker::Impl::Seen(const TrackedImage& image, const SE3& T_ab,
                                      const FramePose& report, bool carried) const {
  MotionModel::Seen seen;
  seen.a = track_.utime;
  seen.b = image.utime;
  seen.T_ab = T_ab;
  const bool in_a_row = !track_.vision_broken() && carried && !cleaner_.depth_spoilt();
  seen.healthy = in_a_row && report.q >= kHealthyQuality;
  // Enough to see that dead reckoning is far off, which need not wait for full health.
  seen.sure =
      in_a_row && report.q >= kSureQuality && report.num_inliers >= Recovery::kConvincingInliers;
  if (!seen.sure) return seen;
  const PoseEstimate& e = image.found.estimate;
  seen.T_WC_vision = VisionAlone(image.T_WC_predicted, e);
  seen.cov_vision = VisionCovariance(e.vision_information);
  return seen;
}

// Doubt and questions about where this image was taken. Call when its pose is decided, before a
// keyframe is made of it.
void Tracker::Impl::ConsiderPlace(const TrackedImage& image, TrackerOutput* out,
                                  ImageOutcome* outcome) {
  FramePose& report = out->pose;
  const bool placed_now = track_.placed() || outcome->vision;
  const PlaceEvidence evidence =
      judge_.Evidence(image, placed_now, outcome->vision ? report.num_inliers : 0);
  // An empty map begins where this tracker is.
  const bool known = placed_now || image.hinted || (map_.known() && map_.empty());
  const PlaceWatch::Verdict verdict = place_.Observe(evidence, *image.frame, known);
  if (verdict.ask) {
    out->query = PlaceQuery{report.utime, 0, image.frame->features, image.frame->descriptors};
  }
  claims_place_ = verdict.sure && !map_.piece().valid();
  if (verdict.map_on && growth_.CanBeginPiece(*image.frame)) BeginPiece(outcome);
  if (claims_place_ || !evidence.map_there) return;
  outcome->place_known = false;
  report.reason =
      known && !verdict.sure ? TrackingReason::kPoseJump : TrackingReason::kPlaceUnknown;
}

bool Tracker::Impl::Push(const MapUpdate& update) {
  const auto T_WK_before = map_.KeyframePose(track_.reference);
  if (!map_.Apply(update)) return false;
  track_.chain.Skip(update.newest_keyframe);

  // The pose follows the keyframe it is expressed in.
  if (T_WK_before) {
    const CameraTrack::Correction correction = track_.FollowReference(*T_WK_before, update, &map_);
    joined_ |= correction.joined;
    motion_.MapMoved(correction.T);
  }
  FollowMerges(update.merged_landmarks, &track_.points);
  witnesses_.Merge(update.merged_landmarks);
  return true;
}

void Tracker::Impl::Push(const Pose& pose) {
  if (!track_.placed() && pose.has_map && pose.ClaimsPlace()) hint_ = pose;
}

void Tracker::Impl::Push(const PlaceMatch& match) {
  const auto T_OC = motion_.OdometryPose(match.utime);
  if (!T_OC) return;
  place_.Answer(match, *T_OC, map_.PieceOf(match.keyframe).value_or(KeyframeId{}));
}

MapRequest Tracker::Impl::Request() const {
  MapRequest request;
  request.utime = track_.utime;
  request.has_guess = track_.placed() || hint_.has_value();
  request.T_WC_guess = hint_ ? hint_->T_WB * camera_.T_BC : track_.T_WC;
  return request;
}

Result<Tracker> Tracker::Create(const FrontendConfig& config, const CameraGeometry& geometry) {
  OrbConfig orb = config.orb;
  orb.corners_only = config.dr_weight.Departs(Departure::kCorners);
  Result<FeatureExtractor> extractor = FeatureExtractor::Create(orb, geometry);
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
DrConstantFault Tracker::dr_fault() const {
  return impl_->dr_fault();
}
LengthFault Tracker::length_fault() const {
  return impl_->length_fault();
}
ViewFault Tracker::view_fault() const {
  return impl_->view_fault();
}
bool Tracker::has_map() const {
  return impl_->has_map();
}

}  // namespace gw::frontend

#include "frontend/core/tracking/tracker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/core/clock_watch.h"
#include "common/good_weights/camera_motion.h"
#include "common/good_weights/quality.h"
#include "common/good_weights/vision_noise.h"
#include "frontend/core/features/image_cleaner.h"
#include "frontend/core/map/local_map.h"
#include "frontend/core/map/tracked_points.h"
#include "frontend/core/motion/anchor_history.h"
#include "frontend/core/motion/motion_model.h"
#include "frontend/core/motion/pose_uncertainty.h"
#include "frontend/core/place/piece_start.h"
#include "frontend/core/place/place_confirmation.h"
#include "frontend/core/place/recovery.h"
#include "frontend/core/place/view_change.h"
#include "frontend/core/tracking/frame_detail.h"
#include "frontend/core/tracking/keyframe_chain.h"
#include "frontend/core/tracking/pose_finder.h"
#include "frontend/core/tracking/tracking_state.h"
#include "frontend/core/tracking/witnesses.h"

namespace gw::frontend {
namespace {

constexpr int kMinInitialLandmarks = 50;  // fewer do not carry the next image
// A correction larger than this is announced (status RECOVERING).
constexpr double kSnapTranslation = 0.02;  // m
constexpr double kSnapRotation = 0.0175;   // rad
// Quality from which a pose may contradict dead reckoning: half of what there is to be seen is.
constexpr double kSureQuality = 0.5;
// How far the robot may go in the few images that it takes to see that the clock was set back.
constexpr double kMovedMeanwhile = 0.3;   // m
constexpr double kTurnedMeanwhile = 0.3;  // rad
// A POSE that is less sure than this does not know where it is itself.
constexpr double kHintSigma = 1.0;  // m

// The landmarks that the image begins carry the next image.
bool CarriesTheNext(const FeatureFrame& frame) {
  return std::count_if(frame.features.begin(), frame.features.end(),
                       [](const Feature& f) { return f.has_depth(); }) >= kMinInitialLandmarks;
}

}  // namespace

class Tracker::Impl {
 public:
  Impl(const FrontendConfig& config, const CameraGeometry& geometry, FeatureExtractor extractor)
      : config_(config),
        camera_(geometry.rectified),
        extractor_(std::move(extractor)),
        finder_(config, camera_, Pyramid(config.orb.scale_factor, config.orb.num_levels)),
        map_(camera_, Pyramid(config.orb.scale_factor, config.orb.num_levels)),
        motion_(camera_, config),
        cleaner_(camera_, Pyramid(config.orb.scale_factor, config.orb.num_levels)),
        view_(camera_),
        place_(Departs(Departure::kRecovery)),
        piece_start_(camera_),
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
  DrConstantFault dr_fault() const { return motion_.dr_fault(); }

 private:
  // One image on its way to a pose.
  struct Image {
    Utime utime;
    const FeatureFrame* of_world = nullptr;  // without what is fixed to the camera
    const FeatureFrame* frame = nullptr;     // ... corrected for the motion
    Motion motion;                           // since the image before; where hinted, from the hint
    SE3 T_ab;                                // since the image before, in any case
    SE3 T_WC_before;                         // where the motion begins
    SE3 T_WC_predicted;                      // and ends
    bool hinted = false;
    FoundPose found;
    bool agreed = false;   // with dead reckoning, around whose prediction the pose was found
    bool snapped = false;  // found from a confirmed place, and believed

    Witnesses::OfDr of_dr() const { return {utime, T_WC_predicted, motion.weight_cov}; }
  };

  bool Departs(Departure d) const { return config_.dr_weight.Departs(d); }
  bool VisionBroken() const { return state_ != TrackingState::kTracking; }
  bool placed() const { return IsPlaced(state_); }
  bool map_there() const { return map_known_ && !map_.empty(); }

  const FeatureFrame* LeaveOutFixed(Utime utime, const FeatureFrame& seen);
  void Rewind(Utime since);
  void RememberAnchor();
  TrackerOutput Refuse(TrackerOutput out) const;
  void Restart(Utime utime);
  Image Predict(Utime utime);
  void Locate(Image* image);
  FoundPose Find(Image* image);
  std::optional<FoundPose> FindAlone(Image* image, const FoundPose& other);
  FoundPose Decide(const PosePrediction& prediction, Image* image, FoundPose found);
  void Show(const SE3& T_ab, Image* image);
  FoundPose FindAnywhere(Utime utime);
  bool TakePlace(Image* image);
  bool IsBelieved(const Image& image, const FramePose& report);
  bool Believable(const Image& image);
  PlaceEvidence Evidence(const Image& image, const FramePose& report, bool placed,
                         int num_inliers) const;
  void Accept(const Image& image, FramePose* report, ImageOutcome* outcome);
  void GoOnWithout(const Image& image, FramePose* report, const ImageOutcome& outcome);
  void Judge(Image* image, TrackerOutput* out);
  void CompareViews(const Image& image);
  MotionModel::Seen Seen(const Image& image, const SE3& T_ab, const FramePose& report,
                         bool carried) const;
  void ConsiderPlace(const Image& image, TrackerOutput* out, ImageOutcome* outcome);
  bool BeginsMap(const FeatureFrame& frame) const;
  bool CanBeginPiece(const FeatureFrame& frame) const;
  void BeginPiece(ImageOutcome* outcome);
  bool ContinuesMap(bool vision, const Motion& motion) const;
  Keyframe MakeKeyframe(const FeatureFrame& frame, const FoundPose& found, const FramePose& report);
  void FillPose(FramePose* report) const;
  void FillMotion(FramePose* report);

  FrontendConfig config_;
  RectifiedCamera camera_;
  FeatureExtractor extractor_;
  PoseFinder finder_;
  LocalMap map_;
  MotionModel motion_;
  FeatureFrame frame_;
  ImageCleaner cleaner_;
  AnchorHistory anchors_;
  ViewChange view_;
  bool other_view_ = false;  // the newest image shows nothing of the one before

  bool map_known_ = false;   // a snapshot has come
  bool map_frozen_ = false;  // the back-end takes in no keyframes: none are made
  TrackingState state_ = TrackingState::kStart;
  ClockWatch clock_;
  Utime utime_;  // of the last image
  SE3 T_WC_;
  PoseUncertainty uncertainty_;  // of T_WC_
  Recovery recovery_;
  std::vector<TrackedPoint> tracked_;
  Witnesses witnesses_{&motion_, &anchors_};
  std::optional<Pose> hint_;
  PlaceConfirmation place_;
  PieceStart piece_start_;
  // To be tracked from at the next image; in this piece of the map.
  std::optional<PlaceConfirmation::Confirmed> confirmed_;
  KeyframeId confirmed_piece_;
  bool joined_ = false;        // the piece in use became part of another: the next pose jumps
  bool claims_place_ = false;  // the newest image's pose; false: it may be anywhere

  KeyframeId reference_;  // keyframe the pose is expressed in
  KeyframeChain chain_;
};

// Gives the image to the pose finder, corrected for the motion since the image before.
void Tracker::Impl::Show(const SE3& T_ab, Image* image) {
  image->frame = cleaner_.Correct(image->of_world, T_ab, image->utime - utime_);
  finder_.SetImage(image->frame, static_cast<uint64_t>(image->utime.us));
}

// The pose at constant velocity, without dead reckoning, if it is founded, convincing, and has no
// fewer inliers than `other`. Vision that carried the image before is then not overruled.
std::optional<FoundPose> Tracker::Impl::FindAlone(Image* image, const FoundPose& other) {
  const Motion motion = motion_.Coast(utime_, image->utime);
  Show(motion.T_ab, image);
  PosePrediction prediction;
  prediction.T_WC = T_WC_ * motion.T_ab;
  prediction.search_cov = prediction.weight_cov = motion.weight_cov;
  FoundPose alone = finder_.Follow(prediction, tracked_, reference_, &map_);
  const int fewest = std::max(Recovery::kConvincingInliers, other.estimate.num_inliers);
  if (alone.found && alone.estimate.num_inliers >= fewest && witnesses_.Founded(alone, tracked_)) {
    return alone;
  }
  Show(image->T_ab, image);
  return std::nullopt;
}

// Between dead reckoning that has been sound, the pose `found` around its prediction, which
// contradicts it, and vision alone. The rest of the image decides, and landmarks that are known to
// stand still.
FoundPose Tracker::Impl::Decide(const PosePrediction& prediction, Image* image, FoundPose found) {
  if (found.found && witnesses_.KnowAny()) {
    FoundPose rest = finder_.FollowRest(prediction, found, reference_, &map_);
    if (rest.found) {
      // What fits to this pose besides is a witness from now on.
      finder_.Complete(&map_, &rest);
      image->agreed = true;
      witnesses_.Refute(image->utime);
      return rest;
    }
  }
  if (auto alone = FindAlone(image, found)) return *alone;
  const bool refuted = witnesses_.Refuted(image->utime);
  if (found.found && (refuted || !witnesses_.Founded(found, tracked_))) {
    if (!refuted) Rewind(image->utime - StandingLandmarks::kProof);
    image->T_WC_before = T_WC_;
    image->T_WC_predicted = T_WC_ * image->motion.T_ab;
    found.found = false;
    found.reason = TrackingReason::kPoseJump;
  }
  return found;
}

// Around the prediction.
FoundPose Tracker::Impl::Find(Image* image) {
  const Motion& motion = image->motion;
  PosePrediction prediction;
  prediction.T_WC = image->T_WC_predicted;
  prediction.search_cov = motion.weight_cov;
  prediction.has_prior = motion.from_dr;
  prediction.any_matches = !Departs(Departure::kInlierGate);
  prediction.weight_cov = motion.weight_cov;
  prediction.vision_broken = VisionBroken();
  if (prediction.vision_broken) {
    prediction.search_cov += uncertainty_.cov();
  }
  // The mean of the prior is the drifted pose: it counts with that drift, and no more.
  const bool drifted = prediction.vision_broken && Departs(Departure::kDrift);
  if (drifted) prediction.weight_cov = prediction.search_cov;
  if (AdaptsAlpha(config_.variant) && Departs(Departure::kBound)) {
    prediction.honest_cov = drifted ? prediction.search_cov : motion.noise.Covariance();
  }
  FoundPose found = finder_.Follow(prediction, tracked_, reference_, &map_);
  const bool asks = motion.from_dr && !prediction.vision_broken && Departs(Departure::kTrust);
  if (asks) {
    image->agreed = !witnesses_.Contradict(image->of_dr(), found);
    if (!image->agreed) return Decide(prediction, image, std::move(found));
    if (witnesses_.Stands(found)) witnesses_.Clear();
    // What little is found around a wrong prediction agrees with it.
    if (!witnesses_.Founded(found, tracked_)) {
      if (auto alone = FindAlone(image, found)) {
        image->agreed = false;
        return *alone;
      }
    }
  }
  if (!found.found && !motion.from_dr) {
    FoundPose again = finder_.FindAgain(T_WC_, static_cast<uint64_t>(image->utime.us), &map_);
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
bool Tracker::Impl::TakePlace(Image* image) {
  const auto T_OC = motion_.OdometryPose(utime_);
  if (!T_OC) return false;
  const Motion& motion = image->motion;
  const SE3 T_WC = confirmed_->T_WO * *T_OC;  // of the last image
  const SE3 T_WC_predicted = T_WC * motion.T_ab;
  PoseUncertainty uncertainty;
  uncertainty.Reset(confirmed_->cov_T_WC);
  uncertainty.Predict(motion.T_ab, motion.noise, image->utime - utime_);
  PosePrediction prediction;
  prediction.T_WC = T_WC_predicted;
  prediction.search_cov = uncertainty.cov() + motion.weight_cov;
  prediction.has_prior = motion.from_dr;
  prediction.weight_cov = prediction.honest_cov = prediction.search_cov;
  prediction.vision_broken = true;
  const KeyframeId piece_before = map_.piece();
  map_.Use(confirmed_piece_);
  image->found = finder_.Follow(prediction, {}, {}, &map_);
  const PoseEstimate& e = image->found.estimate;
  if (!image->found.found || !SamePlace(T_WC_predicted.inverse() * e.T_WC)) {
    map_.Use(piece_before);
    return false;
  }
  const bool carried =
      place_.in_doubt() || map_.piece() != piece_before ||
      !PosesAgree(image->T_WC_predicted, e.T_WC,
                  uncertainty_.cov() + motion.weight_cov + VisionCovariance(e.vision_information));
  // Dead reckoning then does not lead from the last keyframe to here.
  if (carried) chain_.Break();
  image->T_WC_before = T_WC;
  image->T_WC_predicted = T_WC_predicted;
  uncertainty_ = uncertainty;
  return true;
}

// Finds the pose of the image in the map, if there is one.
void Tracker::Impl::Locate(Image* image) {
  finder_.SetImage(image->frame, static_cast<uint64_t>(image->utime.us));
  image->snapped = confirmed_ && TakePlace(image);
  confirmed_.reset();
  if (image->snapped) return;
  image->found = placed() || image->hinted ? Find(image) : FindAnywhere(image->utime);
}

// True when a pose that vision finds after it was broken is to be believed. Call after uncertainty_
// was predicted.
bool Tracker::Impl::Believable(const Image& image) {
  const PoseEstimate& e = image.found.estimate;
  const Matrix6d cov = VisionCovariance(e.vision_information);
  const Matrix6d& motion_cov = image.motion.weight_cov;
  std::optional<Recovery::Expectation> expected;
  if (placed() || image.hinted) {
    expected = Recovery::Expectation{image.T_WC_predicted, uncertainty_.cov() + motion_cov,
                                     place_.in_doubt()};
  }
  const Recovery::Verdict verdict =
      recovery_.Judge({e.T_WC, cov, e.num_inliers, image.T_ab, motion_cov}, expected);
  // Dead reckoning does not lead from the last keyframe to here.
  if (verdict == Recovery::Verdict::kElsewhere) chain_.Break();
  return verdict != Recovery::Verdict::kWait;
}

// True when the pose that vision found is taken over. What it finds after it was broken has to be
// believed; without dead reckoning there is nothing to hold against it, but that the place is in
// doubt or not known.
bool Tracker::Impl::IsBelieved(const Image& image, const FramePose& report) {
  if (image.snapped || !Departs(Departure::kRecovery)) return true;
  if (witnesses_.Refuted(image.utime) && !witnesses_.Stands(image.found)) return false;
  const bool judged = VisionBroken() && (image.motion.from_dr || !placed() || place_.in_doubt());
  if (judged) return Believable(image);
  return !place_.Contradicts(Evidence(image, report, placed(), image.found.estimate.num_inliers));
}

// Takes over the pose of an image that vision carries.
void Tracker::Impl::Accept(const Image& image, FramePose* report, ImageOutcome* outcome) {
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
  outcome->corrected = image.snapped || (state_ == TrackingState::kBlind &&
                                         (correction.translation().norm() > kSnapTranslation ||
                                          LogSO3(correction.rotation()).norm() > kSnapRotation));
  uncertainty_.Update(e.vision_information, e.prior_information);
  T_WC_ = e.T_WC;
  reference_ = found.reference;
  tracked_.clear();
  for (size_t i = 0; i < found.landmarks.size(); ++i) {
    if (!found.landmarks[i].valid()) continue;
    const Feature& f = image.frame->features[i];
    tracked_.push_back({found.landmarks[i], image.frame->descriptors[i], f.level});
  }
  witnesses_.Learn(image.of_dr(), image.agreed, found);
  recovery_.Reset();
}

// Without a pose from vision that is believed.
void Tracker::Impl::GoOnWithout(const Image& image, FramePose* report,
                                const ImageOutcome& outcome) {
  if (outcome.unconfirmed) {
    report->reason = TrackingReason::kPoseJump;
  } else {
    recovery_.Reset();
  }
  T_WC_ = image.T_WC_predicted;
  report->dr_share = image.motion.from_dr ? 1.0 : 0.0;
}

// There is no map yet, and this image shows enough to begin it.
bool Tracker::Impl::BeginsMap(const FeatureFrame& frame) const {
  if (map_frozen_ || !map_known_ || !map_.empty()) return false;
  return CarriesTheNext(frame);
}

// It shows enough to begin a piece of the map, as it would to begin a map.
bool Tracker::Impl::CanBeginPiece(const FeatureFrame& frame) const {
  if (map_frozen_ || !map_there() || !DrInLocalBa(config_.variant)) return false;
  return CarriesTheNext(frame) && frame.num_detected >= PlaceConfirmation::kRich;
}

// The piece begins where dead reckoning has led: its frame is W as far as the robot knows it, and
// the pose in that frame goes on without a step. What was seen before belongs to another piece.
void Tracker::Impl::BeginPiece(ImageOutcome* outcome) {
  outcome->begins_piece = true;
  map_.Use(chain_.next());
  chain_.Break();
  uncertainty_ = PoseUncertainty();
  uncertainty_.Reset(Matrix6d::Identity() * 1e-12);  // by definition
  tracked_.clear();
  witnesses_.Forget();
  recovery_.Reset();
  place_ = PlaceConfirmation(Departs(Departure::kRecovery));
  piece_start_ = PieceStart(camera_);
}

// An image may become a keyframe when it is known where it was taken, by vision or dead reckoning.
bool Tracker::Impl::ContinuesMap(bool vision, const Motion& motion) const {
  if (map_frozen_ || (map_known_ && map_.empty()) || place_.in_doubt()) return false;
  return vision || (placed() && motion.from_dr && DrInLocalBa(config_.variant));
}

Keyframe Tracker::Impl::MakeKeyframe(const FeatureFrame& frame, const FoundPose& found,
                                     const FramePose& report) {
  Keyframe k = chain_.Make(
      {frame, found, report, T_WC_, uncertainty_.cov(), map_.piece(), map_.revision()}, motion_);
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

// The image without what is fixed to the camera.
const FeatureFrame* Tracker::Impl::LeaveOutFixed(Utime utime, const FeatureFrame& seen) {
  // Without dead reckoning there is nothing to hold against what stands still.
  if (!Departs(Departure::kLooksHealthy) || !DrPredicts(config_.variant) ||
      motion_.newest_dr() == nullptr) {
    return &seen;
  }
  std::optional<CameraStep> step;
  if (state_ != TrackingState::kStart) step = motion_.Step(utime_, utime);
  if (!step) anchors_.Clear();  // dead reckoning may have begun anew, somewhere else
  const bool prevailed = cleaner_.fixed_prevails();
  const FeatureFrame* const of_world = cleaner_.LeaveOutFixed(utime, seen, step);
  if (cleaner_.fixed_prevails() && !prevailed) Rewind(cleaner_.fixed_since());
  return of_world;
}

// Vision was held by what is not the world: the way since then is that of dead reckoning.
void Tracker::Impl::Rewind(Utime since) {
  const auto T_OC = motion_.OdometryPose(utime_);
  const auto then = anchors_.From(since);
  if (!T_OC || !then) return;
  const SE3 T_WC = then->T_WO * *T_OC;
  uncertainty_.Shift((T_WC_.inverse() * T_WC).Log());
  T_WC_ = T_WC;
  motion_.ObserveNothing();
  // Dead reckoning leads from the true pose of the last keyframe, which it does not have.
  chain_.Break();
}

void Tracker::Impl::RememberAnchor() {
  if (const auto T_OC = motion_.OdometryPose(utime_)) {
    anchors_.Remember(utime_, T_WC_ * T_OC->inverse());
  } else {
    anchors_.Clear();
  }
}

// Answers an image that is not newer than the one before, and is not used.
TrackerOutput Tracker::Impl::Refuse(TrackerOutput out) const {
  out.pose.reason = TrackingReason::kTimeReversed;
  out.pose.status = StatusOf(state_, {.time_reversed = true});
  FillPose(&out.pose);
  return out;
}

// The clock was set back: the time of the last image is made to be just before this one. How much
// time passed since nobody knows; the robot is looked for around where it was, as after a blind
// span.
void Tracker::Impl::Restart(Utime utime) {
  if (placed()) state_ = TrackingState::kBlind;
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(kMovedMeanwhile), Eigen::Vector3d::Constant(kTurnedMeanwhile);
  const Matrix6d moved = sigma.cwiseAbs2().asDiagonal();
  const Matrix6d cov = uncertainty_.cov() + moved;
  uncertainty_ = PoseUncertainty();
  uncertainty_.Reset(cov);
  utime_ = utime - DurationUs{1};
  place_ = PlaceConfirmation(Departs(Departure::kRecovery));
  confirmed_.reset();
  recovery_.Reset();
  view_ = ViewChange(camera_);
  anchors_.Clear();
  witnesses_.Clear();
  motion_.Restart();
  chain_.Restart(utime);
}

// Where the image should have been taken, and how sure that is.
Tracker::Impl::Image Tracker::Impl::Predict(Utime utime) {
  Image image;
  image.utime = utime;
  if (state_ == TrackingState::kStart) {
    T_WC_ = motion_.FirstPose(utime);
    uncertainty_.Reset(Matrix6d::Identity() * 1e-12);  // by definition
  } else {
    image.motion = motion_.Between(utime_, utime);
    uncertainty_.Predict(image.motion.T_ab, image.motion.noise, utime - utime_);
  }
  image.T_ab = image.motion.T_ab;
  image.hinted = !placed() && hint_ && !map_.empty();
  if (image.hinted) {
    // From where POSE of the DR process says that the body was, in place of the last image's pose.
    T_WC_ = hint_->T_WB * camera_.T_BC;
    image.motion.T_ab = SE3();
    uncertainty_.Reset(InCamera(hint_->cov_T_WB, camera_.T_BC));
  }
  image.T_WC_before = T_WC_;
  image.T_WC_predicted = T_WC_ * image.motion.T_ab;
  return image;
}

// Finds out whether the image shows another scene than the one before. Many inliers answer the
// question; else the images are compared.
void Tracker::Impl::CompareViews(const Image& image) {
  const std::optional<SE3> T_OC = motion_.OdometryPose(image.utime);
  const bool weak = VisionBroken() || !image.found.found ||
                    image.found.estimate.num_inliers < PlaceConfirmation::kByChance;
  other_view_ = weak && view_.Changed(image.utime, *image.frame, T_OC);
  view_.Remember(image.utime, *image.frame, T_OC);
}

TrackerOutput Tracker::Impl::Track(Utime utime, int64_t seq, const FeatureFrame& seen,
                                   TrackingReason image_problem) {
  TrackerOutput out;
  FramePose& report = out.pose;
  report.utime = utime;
  report.seq = seq;
  out.detail.utime = utime;
  out.detail.seq = seq;
  const ClockWatch::Verdict order = clock_.Judge(utime);
  report.num_detected = seen.num_detected;
  if (order == ClockWatch::Verdict::kLate) return Refuse(std::move(out));
  if (order == ClockWatch::Verdict::kSetBack) Restart(utime);

  const FeatureFrame* const of_world = LeaveOutFixed(utime, seen);
  report.num_detected = of_world->num_detected;
  Image image = Predict(utime);
  image.frame = image.of_world = of_world;
  if (state_ != TrackingState::kStart) {
    if (Departs(Departure::kLooksHealthy))
      cleaner_.JudgeEyes(seen, image.T_ab, image.utime - utime_);
    image.frame = cleaner_.Correct(of_world, image.T_ab, image.utime - utime_);
  }
  report.reason = image_problem;
  if (image_problem == TrackingReason::kNone) {
    report.reason = TrackingReason::kNoMap;
    if (map_there()) {
      Locate(&image);
      report.num_tracked = image.found.num_tracked;
      report.q = image.found.q;
      report.alpha = image.motion.from_dr ? image.found.scale.rotation : 0;
      report.reason = image.found.reason;
    }
  }
  CompareViews(image);
  Judge(&image, &out);
  FillPose(&report);
  FillMotion(&report);
  return out;
}

// From what was found to a pose, a status, and perhaps a keyframe.
void Tracker::Impl::Judge(Image* image, TrackerOutput* out) {
  FramePose& report = out->pose;
  ImageOutcome outcome;
  outcome.map_there = map_there();
  outcome.from_dr = image->motion.from_dr;
  outcome.vision = image->found.found && IsBelieved(*image, report);
  outcome.unconfirmed = image->found.found && !outcome.vision;
  outcome.begins_map = BeginsMap(*image->frame);
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
  const bool carried = StatusOf(state_, outcome) == TrackingStatus::kTracking;
  outcome.contradicted =
      !motion_.dr_trusted() || cleaner_.fixed_prevails() || cleaner_.depth_spoilt();
  report.status = StatusOf(state_, outcome);
  if (outcome.begins_map) report.reason = TrackingReason::kNone;
  if (cleaner_.depth_spoilt()) report.reason = TrackingReason::kEyesApart;
  if (cleaner_.fixed_prevails()) report.reason = TrackingReason::kFixedInImage;
  if (report.reason == TrackingReason::kNone && !motion_.dr_trusted()) {
    report.reason = TrackingReason::kDrContradictsVision;
  }

  const bool first = state_ == TrackingState::kStart;
  const SE3 T_ab = image->T_WC_before.inverse() * T_WC_;
  if (!outcome.vision || witnesses_.Refuted(image->utime)) {
    motion_.ObserveNothing();
  } else if (!first) {
    motion_.Observe(Seen(*image, T_ab, report, carried), image->motion);
  }
  chain_.Observe(first ? SE3() : T_ab,
                 !outcome.vision && report.num_detected >= config_.keyframe_min_close);
  state_ = NextState(state_, outcome);
  utime_ = image->utime;
  RememberAnchor();
  hint_.reset();
  const bool due =
      !outcome.begins_piece && ContinuesMap(outcome.vision, image->motion) &&
      chain_.WantsNext(image->utime, *image->frame, image->found, map_.NumLandmarks(reference_));
  if (outcome.begins_map || outcome.begins_piece || due) {
    if (config_.matching != Matching::kAll) finder_.Complete(&map_, &image->found);
    out->keyframe = MakeKeyframe(*image->frame, image->found, report);
    MarkNewLandmarks(*out->keyframe, &out->detail);
  }
}

// What vision measured since the image before. carried: vision carries this pose, whether dead
// reckoning agrees or not.
MotionModel::Seen Tracker::Impl::Seen(const Image& image, const SE3& T_ab, const FramePose& report,
                                      bool carried) const {
  MotionModel::Seen seen;
  seen.a = utime_;
  seen.b = image.utime;
  seen.T_ab = T_ab;
  const bool in_a_row = !VisionBroken() && carried && !cleaner_.depth_spoilt();
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

// What an image tells of the place; num_inliers: of the pose from vision, 0 when it has none.
PlaceEvidence Tracker::Impl::Evidence(const Image& image, const FramePose& report, bool placed,
                                      int num_inliers) const {
  PlaceEvidence e;
  e.utime = image.utime;
  e.placed = placed;
  e.map_there = map_there();
  e.num_inliers = num_inliers;
  e.relocalised = image.snapped;
  e.num_detected = report.num_detected;
  e.other_view = other_view_;
  e.T_OC = motion_.OdometryPose(image.utime);
  return e;
}

// Doubt and questions about where this image was taken. Call when its pose is decided, before a
// keyframe is made of it.
void Tracker::Impl::ConsiderPlace(const Image& image, TrackerOutput* out, ImageOutcome* outcome) {
  FramePose& report = out->pose;
  const bool placed_now = placed() || outcome->vision;
  const PlaceEvidence evidence =
      Evidence(image, report, placed_now, outcome->vision ? report.num_inliers : 0);
  if (place_.Observe(evidence)) {
    out->query = PlaceQuery{report.utime, 0, image.frame->features, image.frame->descriptors};
  }
  // An empty map begins where this tracker is.
  const bool known = placed_now || image.hinted || (map_known_ && map_.empty());
  const bool sure = known && !place_.in_doubt();
  const bool in_piece = map_.piece().valid();
  claims_place_ = sure && !in_piece;
  const bool lost = !sure && evidence.map_there;
  if (piece_start_.Observe(image.utime, !lost, *image.frame, evidence.T_OC) &&
      CanBeginPiece(*image.frame)) {
    BeginPiece(outcome);
  }
  if (claims_place_ || !evidence.map_there) return;
  outcome->place_known = false;
  report.reason = known && !sure ? TrackingReason::kPoseJump : TrackingReason::kPlaceUnknown;
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
    if (const auto piece = map_.PieceOf(reference_); piece && *piece != map_.piece()) {
      // Its frame is another one now, in which the pose is as sure as it was in the piece.
      map_.Use(*piece);
      joined_ = true;
      const Matrix6d cov = uncertainty_.cov();
      uncertainty_ = PoseUncertainty();
      uncertainty_.Reset(cov);
    } else {
      uncertainty_.Shift((T_WC_before.inverse() * T_WC_).Log());
    }
    const SE3 T_correction = T_WC_ * T_WC_before.inverse();
    motion_.MapMoved(T_correction);
    anchors_.Move(T_correction);
  }
  FollowMerges(update.merged_landmarks, &tracked_);
  witnesses_.Merge(update.merged_landmarks);
  return true;
}

void Tracker::Impl::Push(const Pose& pose) {
  const double variance = pose.cov_T_WB.diagonal().head<3>().maxCoeff();
  if (!placed() && pose.has_map && variance < kHintSigma * kHintSigma) hint_ = pose;
}

void Tracker::Impl::Push(const PlaceMatch& match) {
  const auto T_OC = motion_.OdometryPose(match.utime);
  if (!T_OC) return;
  if (const auto confirmed = place_.Take(match, *T_OC)) {
    confirmed_ = confirmed;
    confirmed_piece_ = map_.PieceOf(match.keyframe).value_or(KeyframeId{});
  }
}

MapRequest Tracker::Impl::Request() const {
  MapRequest request;
  request.utime = utime_;
  request.has_guess = placed() || hint_.has_value();
  request.T_WC_guess = hint_ ? hint_->T_WB * camera_.T_BC : T_WC_;
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
bool Tracker::has_map() const {
  return impl_->has_map();
}

}  // namespace gw::frontend

#include "frontend/core/tracking/pose_search.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/good_weights/vision_noise.h"
#include "common/vision/same_place.h"
#include "frontend/core/place/recovery.h"

namespace gw::frontend {
namespace {

// Among the features that only one of two poses explains, `a` has more than chance gives it, by
// three standard deviations.
bool ExplainsMore(const FoundPose& a, const FoundPose& b) {
  double only_a = 0, only_b = 0;
  for (size_t i = 0; i < std::min(a.landmarks.size(), b.landmarks.size()); ++i) {
    if (a.landmarks[i].valid() && !b.landmarks[i].valid()) ++only_a;
    if (b.landmarks[i].valid() && !a.landmarks[i].valid()) ++only_b;
  }
  return only_a - only_b > 3 * std::sqrt(only_a + only_b);
}

}  // namespace

PoseSearch::PoseSearch(const FrontendConfig& config, const RectifiedCamera& camera,
                       const TrackerParts& parts)
    : config_(config),
      motion_(parts.motion),
      cleaner_(parts.cleaner),
      map_(parts.map),
      witnesses_(parts.witnesses),
      place_(parts.place),
      track_(parts.track),
      finder_(config, camera, Pyramid(config.orb.scale_factor, config.orb.num_levels)) {}

// Gives the image to the pose finder, corrected for the motion since the image before.
void PoseSearch::Show(const SE3& T_ab, TrackedImage* image) {
  image->frame = cleaner_->Correct(image->of_world, T_ab, image->utime - track_->utime);
  finder_.SetImage(image->frame, static_cast<uint64_t>(image->utime.us));
}

// Landmarks of the image before count that are in view of the pose that was found as well as by
// dead reckoning: what has left the view is no word against a pose.
bool PoseSearch::IsFounded(const TrackedImage& image, const FoundPose& found) const {
  const SE3 T_CW = found.estimate.T_WC.inverse();
  const SE3 T_CW_dr = image.T_WC_predicted.inverse();
  std::vector<TrackedPoint> expected;
  for (const TrackedPoint& point : track_->points) {
    if (map_->PixelOf(point.id, T_CW) && map_->PixelOf(point.id, T_CW_dr))
      expected.push_back(point);
  }
  return witnesses_->Founded(found, expected);
}

// The pose at constant velocity, without dead reckoning, if it is founded, convincing, and has no
// fewer inliers than `other`. Vision that carried the image before is then not overruled.
std::optional<FoundPose> PoseSearch::FindAlone(TrackedImage* image, const FoundPose& other) {
  const Motion motion = motion_->Coast(track_->utime, image->utime);
  Show(motion.T_ab, image);
  PosePrediction prediction;
  prediction.T_WC = track_->T_WC * motion.T_ab;
  prediction.search_cov = prediction.weight_cov = motion.weight_cov;
  FoundPose alone = finder_.Follow(prediction, track_->points, track_->reference, map_);
  const int fewest = std::max(Recovery::kConvincingInliers, other.estimate.num_inliers);
  if (alone.found && alone.estimate.num_inliers >= fewest && IsFounded(*image, alone)) {
    alone.estimate.T_WC = HeldSteady(prediction.T_WC, motion.weight_cov, alone.estimate);
    return alone;
  }
  Show(image->T_ab, image);
  return std::nullopt;
}

// True when the camera would have moved as hardly any does, after its motion until the image
// before.
bool PoseSearch::IsSudden(const TrackedImage& image, const FoundPose& found) const {
  const Motion steady = motion_->Coast(track_->utime, image.utime);
  const SE3 T_WC_steady = track_->T_WC * steady.T_ab;
  const Vector6d change = (T_WC_steady.inverse() * found.estimate.T_WC).Log();
  return (change.cwiseAbs2().array() > steady.weight_cov.diagonal().array()).any();
}

// Between dead reckoning that has been sound, the pose `found` around its prediction, which
// contradicts it, and vision alone. The rest of the image decides, and landmarks that are known to
// stand still.
FoundPose PoseSearch::Decide(const PosePrediction& prediction, TrackedImage* image,
                             FoundPose found) {
  if (found.found && witnesses_->KnowAny()) {
    FoundPose rest = finder_.FollowRest(prediction, found, track_->reference, map_);
    if (rest.found) {
      // What fits to this pose besides is a witness from now on.
      finder_.Complete(map_, &rest);
      image->agreed = true;
      witnesses_->Accuse(image->utime);
      return rest;
    }
  }
  if (auto alone = FindAlone(image, found)) return *alone;
  const bool refuted = witnesses_->Refuted(image->utime);
  if (found.found && (refuted || !IsFounded(*image, found))) {
    if (!refuted) track_->Rewind(image->utime - StandingLandmarks::kProof, motion_);
    image->T_WC_before = track_->T_WC;
    image->T_WC_predicted = track_->T_WC * image->motion.T_ab;
    found.found = false;
    found.reason = TrackingReason::kPoseJump;
  }
  return found;
}

PosePrediction PoseSearch::Prediction(const TrackedImage& image) const {
  const Motion& motion = image.motion;
  PosePrediction prediction;
  prediction.T_WC = image.T_WC_predicted;
  prediction.search_cov = motion.weight_cov;
  prediction.has_prior = motion.from_dr;
  prediction.any_matches = !Departs(Departure::kInlierGate);
  prediction.weight_cov = motion.weight_cov;
  prediction.vision_broken = track_->vision_broken();
  if (prediction.vision_broken) {
    prediction.search_cov += track_->uncertainty.cov();
  }
  // The mean of the prior is the drifted pose: it counts with that drift, and no more.
  const bool drifted = prediction.vision_broken && Departs(Departure::kDrift);
  if (drifted) prediction.weight_cov = prediction.search_cov;
  if (AdaptsAlpha(config_.variant) && Departs(Departure::kBound)) {
    prediction.honest_cov = drifted ? prediction.search_cov : motion.noise.Covariance();
  }
  return prediction;
}

// Around the prediction.
FoundPose PoseSearch::Find(TrackedImage* image) {
  const PosePrediction prediction = Prediction(*image);
  FoundPose found = finder_.Follow(prediction, track_->points, track_->reference, map_);
  const bool asks =
      image->motion.from_dr && !prediction.vision_broken && Departs(Departure::kTrust);
  if (asks) {
    image->agreed = !witnesses_->Contradict(image->of_dr(), found);
    if (!image->agreed) return Decide(prediction, image, std::move(found));
    if (witnesses_->Stands(found)) witnesses_->Clear();
    // What is found around a wrong prediction agrees with it, be it little or a sudden motion.
    const bool founded = IsFounded(*image, found);
    if (!founded || IsSudden(*image, found)) {
      const auto alone = FindAlone(image, found);
      if (alone && (!founded || ExplainsMore(*alone, found))) {
        image->agreed = false;
        return *alone;
      }
    }
  }
  if (!found.found && !image->motion.from_dr) {
    FoundPose again = finder_.FindAgain(track_->T_WC, static_cast<uint64_t>(image->utime.us), map_);
    if (again.found) return again;
  }
  return found;
}

// Where this tracker has no place yet. With dead reckoning, answers of the back-end are compared;
// a look-alike near the origin of W would pass for the place here.
FoundPose PoseSearch::FindAnywhere(Utime utime) {
  FoundPose found;
  if (!motion_->OdometryPose(utime)) {
    found = finder_.FindAgain(track_->T_WC, static_cast<uint64_t>(utime.us), map_);
  }
  if (!found.found) found.reason = TrackingReason::kPlaceUnknown;
  return found;
}

// Tracks the image from the confirmed place, which is taken over when the image is seen there.
bool PoseSearch::TakePlace(const PlaceWatch::Confirmed& confirmed, TrackedImage* image) {
  const auto T_OC = motion_->OdometryPose(track_->utime);
  if (!T_OC) return false;
  const Motion& motion = image->motion;
  const SE3 T_WC = confirmed.T_WO * *T_OC;  // of the last image
  const SE3 T_WC_predicted = T_WC * motion.T_ab;
  PoseUncertainty uncertainty;
  uncertainty.Reset(confirmed.cov_T_WC);
  uncertainty.Predict(motion.T_ab, motion.noise, image->utime - track_->utime);
  PosePrediction prediction;
  prediction.T_WC = T_WC_predicted;
  prediction.search_cov = uncertainty.cov() + motion.weight_cov;
  prediction.has_prior = motion.from_dr;
  prediction.weight_cov = prediction.honest_cov = prediction.search_cov;
  prediction.vision_broken = true;
  const KeyframeId piece_before = map_->piece();
  map_->Use(confirmed.piece);
  image->found = finder_.Follow(prediction, {}, {}, map_);
  const PoseEstimate& e = image->found.estimate;
  if (!image->found.found || !SamePlace(T_WC_predicted.inverse() * e.T_WC)) {
    map_->Use(piece_before);
    return false;
  }
  const bool carried = place_->in_doubt() || map_->piece() != piece_before ||
                       !PosesAgree(image->T_WC_predicted, e.T_WC,
                                   track_->uncertainty.cov() + motion.weight_cov +
                                       VisionCovariance(e.vision_information));
  // Dead reckoning then does not lead from the last keyframe to here.
  if (carried) track_->chain.Break();
  image->T_WC_before = T_WC;
  image->T_WC_predicted = T_WC_predicted;
  track_->uncertainty = uncertainty;
  return true;
}

void PoseSearch::Locate(TrackedImage* image) {
  finder_.SetImage(image->frame, static_cast<uint64_t>(image->utime.us));
  const auto confirmed = place_->TakeConfirmed();
  image->snapped = confirmed && TakePlace(*confirmed, image);
  if (image->snapped) return;
  image->found = track_->placed() || image->hinted ? Find(image) : FindAnywhere(image->utime);
}

}  // namespace gw::frontend

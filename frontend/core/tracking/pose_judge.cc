#include "frontend/core/tracking/pose_judge.h"

#include <optional>

#include "common/good_weights/vision_noise.h"

namespace gw::frontend {

PoseJudge::PoseJudge(const FrontendConfig& config, const TrackerParts& parts)
    : asks_(config.dr_weight.Departs(Departure::kRecovery)),
      motion_(parts.motion),
      map_(parts.map),
      witnesses_(parts.witnesses),
      place_(parts.place),
      track_(parts.track) {}

// Without dead reckoning there is nothing to hold against a pose, but that the place is in doubt or
// not known.
bool PoseJudge::Believes(const TrackedImage& image) {
  if (image.snapped || !asks_) return true;
  if (witnesses_->Refuted(image.utime) && !witnesses_->Stands(image.found)) return false;
  const bool judged =
      track_->vision_broken() && (image.motion.from_dr || !track_->placed() || place_->in_doubt());
  if (judged) return BelievesAfterBreak(image);
  return !place_->Contradicts(Evidence(image, track_->placed(), image.found.estimate.num_inliers));
}

bool PoseJudge::BelievesAfterBreak(const TrackedImage& image) {
  const PoseEstimate& e = image.found.estimate;
  const Matrix6d cov = VisionCovariance(e.vision_information);
  const Matrix6d& motion_cov = image.motion.weight_cov;
  std::optional<Recovery::Expectation> expected;
  if (track_->placed() || image.hinted) {
    expected = Recovery::Expectation{image.T_WC_predicted, track_->uncertainty.cov() + motion_cov,
                                     place_->in_doubt()};
  }
  const Recovery::Verdict verdict =
      recovery_.Judge({e.T_WC, cov, e.num_inliers, image.T_ab, motion_cov}, expected);
  // Dead reckoning does not lead from the last keyframe to here.
  if (verdict == Recovery::Verdict::kElsewhere) track_->chain.Break();
  return verdict != Recovery::Verdict::kWait;
}

PlaceEvidence PoseJudge::Evidence(const TrackedImage& image, bool placed, int num_inliers) const {
  PlaceEvidence e;
  e.utime = image.utime;
  e.placed = placed;
  e.map_there = map_->there();
  e.num_inliers = num_inliers;
  e.relocalised = image.snapped;
  e.num_detected = image.of_world->num_detected;
  e.T_OC = motion_->OdometryPose(image.utime);
  e.dr_trusted = motion_->dr_trusted();
  return e;
}

}  // namespace gw::frontend

#include "frontend/core/tracking/image_intake.h"

#include <utility>
#include <vector>

#include "common/vision/scale_lengths.h"

namespace gw::frontend {

ImageIntake::ImageIntake(const FrontendConfig& config, const TrackerParts& parts)
    : judges_depth_(config.dr_weight.Departs(Departure::kLooksHealthy)),
      looks_for_fixed_(judges_depth_ && DrPredicts(config.variant)),
      motion_(parts.motion),
      cleaner_(parts.cleaner),
      map_(parts.map),
      place_(parts.place),
      track_(parts.track) {}

bool ImageIntake::CorrectLengths() {
  const std::optional<double> too_long = motion_->vision_factor();
  if (!too_long || map_->frozen()) return false;
  const auto center = map_->ScaleLengths(1 / *too_long);
  if (!center) return false;
  track_->ScaleLengths(1 / *too_long, motion_->newest_dr()->way_scale_sigma, *center);
  motion_->VisionCorrected(*too_long);
  place_->Restart();
  return true;
}

const FeatureFrame& ImageIntake::InMetres(const FeatureFrame& seen) {
  if (map_->length_factor() == 1) return seen;
  frame_in_metres_ = seen;
  ScaleLengths(map_->length_factor(), &frame_in_metres_.features);
  return frame_in_metres_;
}

void ImageIntake::JudgeDepth(const TrackedImage& image) {
  if (!judges_depth_ || !cleaner_->depth_sync().Asks()) return;
  std::vector<DepthSync::Sight> sights;
  const SE3 T_CW = image.found.estimate.T_WC.inverse();
  for (size_t i = 0; i < image.found.landmarks.size(); ++i) {
    const MapPoint* const at = map_->Find(image.found.landmarks[i]);
    const double depth = at != nullptr ? (T_CW * at->p_W).z() / map_->length_factor() : 0;
    const Feature& f = image.of_world->features[i];
    if (depth > 0) sights.push_back({f.u, f.v, at->id, depth});
  }
  cleaner_->depth_sync().Observe(std::move(sights));
}

LengthFault ImageIntake::length_fault() const {
  const double left = motion_->vision_factor().value_or(1);
  return {left / map_->length_factor(), left == 1};
}

const FeatureFrame* ImageIntake::LeaveOutFixed(Utime utime, const FeatureFrame& seen) {
  // Without dead reckoning there is nothing to hold against what stands still.
  if (!looks_for_fixed_ || motion_->newest_dr() == nullptr) return &seen;
  std::optional<CameraStep> step;
  if (track_->state != TrackingState::kStart) step = motion_->Step(track_->utime, utime);
  if (!step) track_->anchors.Clear();  // dead reckoning may have begun anew, somewhere else
  const bool prevailed = cleaner_->fixed_prevails();
  const FeatureFrame* const of_world = cleaner_->LeaveOutFixed(utime, seen, step);
  if (cleaner_->fixed_prevails() && !prevailed &&
      !track_->AgreesWithDr(cleaner_->fixed_since(), *motion_)) {
    track_->Rewind(cleaner_->fixed_since(), motion_);
  }
  return of_world;
}

}  // namespace gw::frontend

#include "frontend/core/tracking/map_growth.h"

#include <algorithm>

#include "frontend/core/place/rich_image.h"

namespace gw::frontend {
namespace {

constexpr int kMinInitialLandmarks = 50;  // fewer do not carry the next image

// The landmarks that the image begins carry the next image.
bool CarriesTheNext(const FeatureFrame& frame) {
  return std::count_if(frame.features.begin(), frame.features.end(),
                       [](const Feature& f) { return f.has_depth(); }) >= kMinInitialLandmarks;
}

}  // namespace

MapGrowth::MapGrowth(const FrontendConfig& config, const TrackerParts& parts)
    : maps_by_dr_(DrInLocalBa(config.variant)),
      motion_(parts.motion),
      map_(parts.map),
      place_(parts.place),
      track_(parts.track) {}

bool MapGrowth::BeginsMap(const FeatureFrame& frame) const {
  if (map_->frozen() || !map_->known() || !map_->empty()) return false;
  return CarriesTheNext(frame);
}

bool MapGrowth::CanBeginPiece(const FeatureFrame& frame) const {
  if (map_->frozen() || !map_->there() || !maps_by_dr_) return false;
  return CarriesTheNext(frame) && frame.num_detected >= kRichImage;
}

// An image may become a keyframe when it is known where it was taken, by vision or dead reckoning.
bool MapGrowth::IsDue(const TrackedImage& image, bool vision) const {
  if (map_->frozen() || (map_->known() && map_->empty()) || place_->in_doubt()) return false;
  if (!vision && !(track_->placed() && image.motion.from_dr && maps_by_dr_)) return false;
  return track_->chain.WantsNext(image.utime, *image.frame, image.found,
                                 map_->NumLandmarks(track_->reference));
}

Keyframe MapGrowth::Make(const TrackedImage& image, const FramePose& report) {
  const FeatureFrame& frame = *image.frame;
  Keyframe k =
      track_->chain.Make({frame, image.found, report, track_->T_WC, track_->uncertainty.cov(),
                          map_->piece(), map_->revision(), map_->length_factor()},
                         *motion_);
  for (size_t i = 0; i < k.landmarks.size(); ++i) {
    if (k.landmarks[i] != LandmarkId::From(k.id, static_cast<int>(i))) continue;
    track_->points.push_back({k.landmarks[i], frame.descriptors[i], frame.features[i].level});
  }
  map_->AddKeyframe(k);
  return k;
}

}  // namespace gw::frontend

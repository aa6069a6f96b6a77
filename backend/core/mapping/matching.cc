#include "backend/core/mapping/matching.h"

#include <algorithm>
#include <cmath>

namespace gw::backend {

bool Observes(const Landmark& landmark, KeyframeId keyframe) {
  const auto it =
      std::lower_bound(landmark.observations.begin(), landmark.observations.end(), keyframe,
                       [](const Observation& o, KeyframeId k) { return o.keyframe < k; });
  return it != landmark.observations.end() && it->keyframe == keyframe;
}

std::optional<Projection> Project(const MappingContext& context, const Landmark& landmark,
                                  const SE3& T_WC, const SE3& T_CW) {
  return ProjectLandmark(context.camera, context.pyramid, landmark, T_WC, T_CW);
}

int FindFeature(const MappingContext& context, const Landmark& landmark, const Projection& expected,
                const MapKeyframe& keyframe) {
  // The window of the gate for features one level above the expected one.
  const double radius = std::sqrt(kChi2Pixel) * context.pyramid.Scale(expected.level + 1);
  const auto& features = keyframe.frame.features;
  const auto fits = [&](int i) {
    const PixelObservation pixel = PixelOf(features[static_cast<size_t>(i)], context.pyramid);
    return FitOf(context.camera, pixel, expected.p_C).pixel_ok();
  };
  return FindMostSimilar({features, keyframe.frame.descriptors, keyframe.grid}, expected,
                         static_cast<float>(radius), landmark.descriptor, kMatchHamming, fits)
      .index;
}

}  // namespace gw::backend

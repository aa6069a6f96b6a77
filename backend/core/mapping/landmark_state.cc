#include "backend/core/mapping/landmark_state.h"

#include <algorithm>

namespace gw::backend {
namespace {

constexpr size_t kMaxCompared = 12;

const Feature* FeatureOf(const MapKeyframe& keyframe, const Observation& observation) {
  const size_t index = static_cast<size_t>(observation.feature_index);
  return index < keyframe.frame.features.size() ? &keyframe.frame.features[index] : nullptr;
}

}  // namespace

void RefreshGeometry(Map& map, const MappingContext& context, LandmarkId id) {
  Landmark& landmark = map.MutableLandmark(id);
  if (landmark.observations.empty()) return;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const Observation* reference = &landmark.observations.front();
  for (const Observation& observation : landmark.observations) {
    const MapKeyframe& keyframe = *map.FindKeyframe(observation.keyframe);
    const Eigen::Vector3d ray = landmark.p_W - keyframe.frame.T_WC.translation();
    const double length = ray.norm();
    if (length > 0) sum += ray / length;
    if (observation.keyframe == id.creator()) reference = &observation;
  }
  const double length = sum.norm();
  if (length > 0) landmark.normal_W = sum / length;
  const MapKeyframe& keyframe = *map.FindKeyframe(reference->keyframe);
  const Feature* feature = FeatureOf(keyframe, *reference);
  if (feature == nullptr) return;
  const double distance = (landmark.p_W - keyframe.frame.T_WC.translation()).norm();
  const double max_distance = context.pyramid.MaxDistance(distance, feature->level);
  landmark.max_distance = static_cast<float>(max_distance);
  landmark.min_distance = static_cast<float>(context.pyramid.MinDistance(max_distance));
}

void RefreshDescriptor(Map& map, LandmarkId id) {
  Landmark& landmark = map.MutableLandmark(id);
  std::array<const Descriptor*, kMaxCompared> candidates;
  size_t n = 0;
  for (auto it = landmark.observations.rbegin(); it != landmark.observations.rend(); ++it) {
    const MapKeyframe& keyframe = *map.FindKeyframe(it->keyframe);
    const size_t index = static_cast<size_t>(it->feature_index);
    if (index >= keyframe.frame.descriptors.size()) continue;
    candidates[n++] = &keyframe.frame.descriptors[index];
    if (n == kMaxCompared) break;
  }
  if (n == 0) return;
  int best_median = 257;
  size_t best = 0;
  for (size_t i = 0; i < n; ++i) {
    std::array<int, kMaxCompared> distances;
    for (size_t j = 0; j < n; ++j) distances[j] = HammingDistance(*candidates[i], *candidates[j]);
    const auto middle = distances.begin() + (n - 1) / 2;
    std::nth_element(distances.begin(), middle, distances.begin() + n);
    if (*middle < best_median) {
      best_median = *middle;
      best = i;
    }
  }
  landmark.descriptor = *candidates[best];
}

}  // namespace gw::backend

#include "backend/core/mapping/matching.h"

#include <algorithm>

namespace gw::backend {
namespace {

constexpr double kSearchRadius = 3.0;  // px at level 0
constexpr double kMinCosToNormal = 0.5;
constexpr double kDistanceSlack = 1.2;

}  // namespace

bool Observes(const Landmark& landmark, KeyframeId keyframe) {
  const auto it =
      std::lower_bound(landmark.observations.begin(), landmark.observations.end(), keyframe,
                       [](const Observation& o, KeyframeId k) { return o.keyframe < k; });
  return it != landmark.observations.end() && it->keyframe == keyframe;
}

std::optional<ExpectedSight> Sight(const MappingContext& context, const Landmark& landmark,
                                   const SE3& T_WC, const SE3& T_CW) {
  ExpectedSight out;
  out.p_C = T_CW * landmark.p_W;
  if (!(out.p_C.z() > kMinProjectionDepth)) return std::nullopt;
  out.uv = context.camera.Project(out.p_C);
  if (!context.camera.InImage(out.uv)) return std::nullopt;
  const Eigen::Vector3d ray = landmark.p_W - T_WC.translation();
  const double distance = ray.norm();
  if (distance * kDistanceSlack < landmark.min_distance ||
      distance > landmark.max_distance * kDistanceSlack) {
    return std::nullopt;
  }
  if (ray.dot(landmark.normal_W) < kMinCosToNormal * distance) return std::nullopt;
  out.level = context.PredictLevel(landmark.max_distance, distance);
  return out;
}

int FindFeature(const MappingContext& context, const Landmark& landmark,
                const ExpectedSight& expected, const MapKeyframe& keyframe,
                std::vector<int>& scratch) {
  const double radius = kSearchRadius * context.level_scale[expected.level];
  scratch.clear();
  keyframe.grid.Near(expected.uv.x(), expected.uv.y(), radius, scratch);
  int best = -1;
  int best_distance = kMatchHamming + 1;
  for (const int index : scratch) {
    const Feature& f = keyframe.frame.features[index];
    if (std::abs(f.level - expected.level) > 1) continue;
    const double du = f.u - expected.uv.x();
    const double dv = f.v - expected.uv.y();
    if (du * du + dv * dv > radius * radius) continue;
    if (!FitOf(context.camera, context.Measurement(f), expected.p_C).pixel_ok()) continue;
    const int distance = HammingDistance(landmark.descriptor, keyframe.frame.descriptors[index]);
    if (distance < best_distance) {
      best_distance = distance;
      best = index;
    }
  }
  return best;
}

}  // namespace gw::backend

#include "frontend/core/place/relocalizer.h"

#include <cmath>

#include "common/core/random.h"
#include "common/vision/nearest_two.h"
#include "common/vision/pose_ransac.h"

namespace gw::frontend {
namespace {

constexpr int kMaxDistance = 60;   // Hamming; stricter than tracking, as nothing else guards a pair
constexpr double kMaxRatio = 0.8;  // best to second best
constexpr double kInlierPx = 4.0;  // at level 0
constexpr uint64_t kStream = 0x7265;

std::vector<PointPair> MatchAll(const RectifiedCamera& camera, double scale_factor,
                                const FeatureFrame& frame,
                                const std::vector<const MapPoint*>& points) {
  std::vector<PointPair> pairs;
  for (size_t i = 0; i < frame.features.size(); ++i) {
    const Feature& f = frame.features[i];
    if (!f.has_depth()) continue;
    const NearestTwo near = FindNearestTwo(frame.descriptors[i], points);
    if (near.best > kMaxDistance || near.best > kMaxRatio * near.second) continue;
    pairs.push_back({camera.Unproject(f.u, f.v, f.depth),
                     points[near.index]->p_W,
                     {f.u, f.v},
                     kInlierPx * std::pow(scale_factor, f.level)});
  }
  return pairs;
}

}  // namespace

std::optional<SE3> Relocalize(const RectifiedCamera& camera, double scale_factor,
                              const FeatureFrame& frame, const std::vector<const MapPoint*>& points,
                              int min_inliers, uint64_t seed) {
  const auto found = FindPose(camera, MatchAll(camera, scale_factor, frame, points), min_inliers,
                              CounterRng(seed, kStream, 0));
  if (!found) return std::nullopt;
  return found->T_WC;
}

}  // namespace gw::frontend

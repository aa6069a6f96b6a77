#include "frontend/core/relocalizer.h"

#include <Eigen/Geometry>
#include <cmath>

#include "common/core/random.h"

namespace gw::frontend {
namespace {

constexpr int kMaxDistance = 60;   // Hamming; stricter than tracking, as nothing else guards a pair
constexpr double kMaxRatio = 0.8;  // best to second best
constexpr int kTrials = 300;       // finds a triple among 25 % true pairs with 99 %
constexpr double kInlierPx = 4.0;  // at level 0
constexpr uint64_t kStream = 0x7265;

struct Pair {
  Eigen::Vector3d p_C;
  Eigen::Vector3d p_W;
  Eigen::Vector2d uv;
  double tolerance2;  // px^2
};

std::vector<Pair> MatchAll(const RectifiedCamera& camera, double scale_factor,
                           const FeatureFrame& frame, const std::vector<const MapPoint*>& points) {
  std::vector<Pair> pairs;
  for (size_t i = 0; i < frame.features.size(); ++i) {
    const Feature& f = frame.features[i];
    if (!f.has_depth()) continue;
    int best = 257;
    int second = 257;
    const MapPoint* best_point = nullptr;
    for (const MapPoint* point : points) {
      const int d = HammingDistance(frame.descriptors[i], point->descriptor);
      if (d < best) {
        second = best;
        best = d;
        best_point = point;
      } else if (d < second) {
        second = d;
      }
    }
    if (best > kMaxDistance || best > kMaxRatio * second) continue;
    const double tolerance = kInlierPx * std::pow(scale_factor, f.level);
    pairs.push_back(
        {camera.Unproject(f.u, f.v, f.depth), best_point->p_W, {f.u, f.v}, tolerance * tolerance});
  }
  return pairs;
}

// The rigid motion that takes three points of C to W (Umeyama 1991, no scale).
SE3 Align(const Pair& a, const Pair& b, const Pair& c) {
  Eigen::Matrix3d source;
  Eigen::Matrix3d target;
  source << a.p_C, b.p_C, c.p_C;
  target << a.p_W, b.p_W, c.p_W;
  const Eigen::Matrix4d T = Eigen::umeyama(source, target, false);
  return SE3(Eigen::Quaterniond(Eigen::Matrix3d(T.topLeftCorner<3, 3>())),
             T.topRightCorner<3, 1>());
}

int CountInliers(const RectifiedCamera& camera, const SE3& T_WC, const std::vector<Pair>& pairs) {
  const SE3 T_CW = T_WC.inverse();
  int n = 0;
  for (const Pair& pair : pairs) {
    const Eigen::Vector3d p_C = T_CW * pair.p_W;
    n += p_C.z() > 0.05 && (camera.Project(p_C) - pair.uv).squaredNorm() < pair.tolerance2;
  }
  return n;
}

}  // namespace

std::optional<SE3> Relocalize(const RectifiedCamera& camera, double scale_factor,
                              const FeatureFrame& frame, const std::vector<const MapPoint*>& points,
                              int min_inliers, uint64_t seed) {
  const std::vector<Pair> pairs = MatchAll(camera, scale_factor, frame, points);
  const auto n = static_cast<uint32_t>(pairs.size());
  if (static_cast<int>(n) < std::max(min_inliers, 3)) return std::nullopt;
  CounterRng rng(seed, kStream, 0);
  int best_count = 0;
  SE3 best;
  for (int trial = 0; trial < kTrials; ++trial) {
    const uint32_t i = rng.Below(n);
    const uint32_t j = rng.Below(n);
    const uint32_t k = rng.Below(n);
    if (i == j || j == k || i == k) continue;
    const SE3 T_WC = Align(pairs[i], pairs[j], pairs[k]);
    if (!T_WC.IsFinite()) continue;
    const int count = CountInliers(camera, T_WC, pairs);
    if (count > best_count) {
      best_count = count;
      best = T_WC;
    }
  }
  if (best_count < min_inliers) return std::nullopt;
  return best;
}

}  // namespace gw::frontend

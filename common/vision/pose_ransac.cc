#include "common/vision/pose_ransac.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "common/vision/reprojection.h"

namespace gw {
namespace {

constexpr int kTrials = 300;

// The rigid motion that takes three points of C to W (Umeyama 1991, no scale).
SE3 Align(const PointPair& a, const PointPair& b, const PointPair& c) {
  Eigen::Matrix3d source;
  Eigen::Matrix3d target;
  source << a.p_C, b.p_C, c.p_C;
  target << a.p_W, b.p_W, c.p_W;
  const Eigen::Matrix4d T = Eigen::umeyama(source, target, false);
  return SE3(Eigen::Quaterniond(Eigen::Matrix3d(T.topLeftCorner<3, 3>())),
             T.topRightCorner<3, 1>());
}

bool Agrees(const RectifiedCamera& camera, const SE3& T_CW, const PointPair& pair) {
  const Eigen::Vector3d p_C = T_CW * pair.p_W;
  return p_C.z() > kMinProjectionDepth &&
         (camera.Project(p_C) - pair.uv).squaredNorm() < pair.tolerance_px * pair.tolerance_px;
}

}  // namespace

std::optional<PoseHypothesis> FindPose(const RectifiedCamera& camera,
                                       const std::vector<PointPair>& pairs, int min_inliers,
                                       CounterRng rng) {
  const auto n = static_cast<uint32_t>(pairs.size());
  if (static_cast<int>(n) < std::max(min_inliers, 3)) return std::nullopt;
  PoseHypothesis best;
  for (int trial = 0; trial < kTrials; ++trial) {
    const uint32_t i = rng.Below(n);
    const uint32_t j = rng.Below(n);
    const uint32_t k = rng.Below(n);
    if (i == j || j == k || i == k) continue;
    const SE3 T_WC = Align(pairs[i], pairs[j], pairs[k]);
    if (!T_WC.IsFinite()) continue;
    const SE3 T_CW = T_WC.inverse();
    const auto count =
        static_cast<int>(std::count_if(pairs.begin(), pairs.end(), [&](const PointPair& pair) {
          return Agrees(camera, T_CW, pair);
        }));
    if (count > best.num_inliers) {
      best.num_inliers = count;
      best.T_WC = T_WC;
    }
  }
  if (best.num_inliers < std::max(min_inliers, 3)) return std::nullopt;
  const SE3 T_CW = best.T_WC.inverse();
  for (const PointPair& pair : pairs) best.inlier.push_back(Agrees(camera, T_CW, pair) ? 1 : 0);
  return best;
}

}  // namespace gw

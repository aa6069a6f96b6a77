#include "frontend/core/map/projection_matcher.h"

#include <algorithm>
#include <cmath>

namespace gw::frontend {

ProjectionMatcher::ProjectionMatcher(const RectifiedCamera& camera, const PyramidScale& scale)
    : camera_(camera), log_factor_(std::log(scale.factor)) {
  double s = 1.0;
  for (int i = 0; i < scale.num_levels; ++i, s *= scale.factor) level_scale_.push_back(s);
}

int ProjectionMatcher::PredictLevel(const MapPoint& point, double distance) const {
  const double level = std::log(point.max_distance / distance) / log_factor_;
  return std::clamp(static_cast<int>(std::lround(level)), 0,
                    static_cast<int>(level_scale_.size()) - 1);
}

MatchStatistics ProjectionMatcher::Match(const SE3& T_WC, const std::vector<Candidate>& candidates,
                                         int first_index, const FeatureFrame& frame,
                                         const FeatureGrid& grid, const MatcherLimits& limits,
                                         std::vector<int>* match) const {
  MatchStatistics statistics;
  const SE3 T_CW = T_WC.inverse();
  const Eigen::Matrix3d R_CW = T_CW.rotation().toRotationMatrix();
  const Eigen::Vector3d& p_CW = T_CW.translation();
  const Eigen::Vector3d& p_WC = T_WC.translation();
  // Distance of the match that a feature has got in this call.
  std::vector<int> taken_at(frame.features.size(), limits.max_distance + 1);
  for (size_t i = 0; i < match->size(); ++i) {
    if ((*match)[i] >= 0) taken_at[i] = -1;
  }

  for (size_t c = 0; c < candidates.size(); ++c) {
    const MapPoint& point = *candidates[c].point;
    const Eigen::Vector3d p_C = R_CW * point.p_W + p_CW;
    if (p_C.z() < 0.05) continue;
    const Eigen::Vector2d uv = camera_.Project(p_C);
    if (!camera_.InImage(uv)) continue;
    int level = candidates[c].level;
    const Eigen::Vector3d ray = point.p_W - p_WC;
    const double distance = ray.norm();
    if (level < 0) {
      // A fifth of slack on both sides: the scale estimate of a corner is coarse.
      if (distance < 0.8 * point.min_distance || distance > 1.2 * point.max_distance) continue;
      if (ray.dot(point.normal_W) < limits.min_view_cos * distance) continue;
      level = PredictLevel(point, distance);
    }
    ++statistics.num_visible;

    const float radius = static_cast<float>(candidates[c].radius_px * level_scale_[level]);
    const float u = static_cast<float>(uv.x());
    const float u_right = static_cast<float>(uv.x() - camera_.bf() / p_C.z());
    const Descriptor& wanted = *candidates[c].descriptor;
    int best = limits.max_distance + 1;
    int best_level = -1;
    int second = 257;
    int second_level = -1;
    int best_index = -1;
    grid.ForEachNear(u, static_cast<float>(uv.y()), radius, [&](int i) {
      const Feature& f = frame.features[i];
      if (f.level < level - 1 || f.level > level + 1 || taken_at[i] < 0) return;
      if (f.has_depth() && std::abs(f.u_right - u_right) > 1.5f * radius) return;
      const int d = HammingDistance(wanted, frame.descriptors[i]);
      if (d < best) {
        second = best;
        second_level = best_level;
        best = d;
        best_level = f.level;
        best_index = i;
      } else if (d < second) {
        second = d;
        second_level = f.level;
      }
    });
    if (best_index < 0) continue;
    if (best_level == second_level && best > limits.max_ratio * second) continue;
    if (best >= taken_at[best_index]) continue;
    if (taken_at[best_index] > limits.max_distance) ++statistics.num_matched;
    taken_at[best_index] = best;
    (*match)[best_index] = first_index + static_cast<int>(c);
  }
  return statistics;
}

}  // namespace gw::frontend

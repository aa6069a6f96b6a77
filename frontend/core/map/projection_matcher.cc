#include "frontend/core/map/projection_matcher.h"

#include <cmath>

namespace gw::frontend {
namespace {

// A feature's disparity may be so much farther from the expected one than its window is wide: the
// window is for the pose, and the depth of a young landmark is not known better than its pixel.
constexpr float kDisparitySlack = 1.5F;

}  // namespace

std::optional<Projection> ProjectionMatcher::Expect(const Candidate& candidate, const SE3& T_WC,
                                                    const SE3& T_CW) const {
  if (candidate.level < 0) {
    return ProjectLandmark(camera_, pyramid_, *candidate.point, T_WC, T_CW);
  }
  Projection out;
  out.p_C = T_CW * candidate.point->p_W;
  if (!(out.p_C.z() > kMinProjectionDepth)) return std::nullopt;
  out.uv = camera_.Project(out.p_C);
  out.level = candidate.level;
  if (!camera_.InImage(out.uv)) return std::nullopt;
  return out;
}

int ProjectionMatcher::Match(const SE3& T_WC, const std::vector<Candidate>& candidates,
                             int first_index, const SearchableImage& image,
                             const MatcherLimits& limits, std::vector<int>* match) const {
  const SE3 T_CW = T_WC.inverse();
  int num_matched = 0;
  constexpr int kTaken = -1;  // by an earlier call
  const int kFree = limits.max_distance + 1;
  // Distance of the match that a feature has got in this call.
  std::vector<int> distance_of(image.features.size(), kFree);
  for (size_t i = 0; i < match->size(); ++i) {
    if ((*match)[i] >= 0) distance_of[i] = kTaken;
  }
  for (size_t c = 0; c < candidates.size(); ++c) {
    const auto expected = Expect(candidates[c], T_WC, T_CW);
    if (!expected) continue;
    const auto radius =
        static_cast<float>(candidates[c].radius_px * pyramid_.Scale(expected->level));
    const auto u_right = static_cast<float>(expected->uv.x() - camera_.bf() / expected->p_C.z());
    const BestFeature best = FindMostSimilar(
        image, *expected, radius, *candidates[c].descriptor, limits.max_distance, [&](int i) {
          const Feature& f = image.features[i];
          return distance_of[i] != kTaken &&
                 (!f.has_depth() || std::abs(f.u_right - u_right) <= kDisparitySlack * radius);
        });
    if (best.index < 0) continue;
    if (best.level == best.second_level &&
        best.distance > limits.max_ratio * best.second_distance) {
      continue;
    }
    int& distance = distance_of[best.index];
    if (best.distance >= distance) continue;
    num_matched += distance == kFree;
    distance = best.distance;
    (*match)[best.index] = first_index + static_cast<int>(c);
  }
  return num_matched;
}

}  // namespace gw::frontend

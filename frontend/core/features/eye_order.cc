#include "frontend/core/features/eye_order.h"

#include <cmath>

#include "common/core/log_odds.h"

namespace gw::frontend {
namespace {

constexpr int kAlike = 50;          // of 256 bits, and 0.8 of the second best
constexpr float kRows = 2;          // px of the level
constexpr float kOnePlace = 0.01f;  // px
constexpr float kOffset = 1;        // px of the level: more than noise
// Nearly all partners lie on the side that the order of the eyes says; wrong partners lie on
// either.
constexpr double kMostly = 0.9, kEither = 0.5;

// The right keypoint that alone looks like the i-th left one; null: there is none.
const OrbKeypoint* Partner(const StereoSide& left, size_t i, const StereoSide& right) {
  const OrbKeypoint& k = left.keypoints[i];
  const float reach = kRows * left.pyramid.scale_y(k.level);
  const OrbKeypoint* best = nullptr;
  int distance = kAlike + 1, second = 257;
  for (size_t j = 0; j < right.keypoints.size(); ++j) {
    const OrbKeypoint& r = right.keypoints[j];
    if (r.level != k.level || std::abs(r.v - k.v) > reach) continue;
    const int d = HammingDistance(left.descriptors[i], right.descriptors[j]);
    if (d < distance) {
      second = distance;
      distance = d;
      best = &r;
    } else if (d < second) {
      second = d;
    }
  }
  return distance * 5 > second * 4 ? nullptr : best;
}

}  // namespace

EyeOrder JudgeEyeOrder(const StereoSide& left, const StereoSide& right) {
  int partners = 0, at_one_place = 0, ahead = 0, behind = 0;
  for (size_t i = 0; i < left.keypoints.size(); ++i) {
    const OrbKeypoint& k = left.keypoints[i];
    const OrbKeypoint* const partner = Partner(left, i, right);
    if (partner == nullptr) continue;
    const float disparity = k.u - partner->u;
    const float offset = kOffset * left.pyramid.scale_x(k.level);
    ++partners;
    at_one_place += std::hypot(disparity, k.v - partner->v) < kOnePlace;
    ahead += disparity > offset;
    behind += disparity < -offset;
  }
  if (LogOdds(at_one_place, partners, kMostly, kEither) > kDecisiveLogOdds) {
    return EyeOrder::kOneTwice;
  }
  if (LogOdds(behind, ahead + behind, kMostly, kEither) > kDecisiveLogOdds) {
    return EyeOrder::kExchanged;
  }
  return EyeOrder::kPlausible;
}

}  // namespace gw::frontend

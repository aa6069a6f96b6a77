#include "frontend/core/features/eye_order.h"

#include <cmath>

#include "common/core/log_odds.h"

namespace gw::frontend {
namespace {

constexpr float kRows = 2;          // px of the level
constexpr float kOnePlace = 0.01f;  // px
constexpr float kOffset = 1;        // px of the level: more than noise
// Nearly all partners lie on the side that the order of the eyes says; wrong partners lie on
// either.
constexpr double kMostly = 0.9, kEither = 0.5;

}  // namespace

EyeOrder JudgeEyeOrder(const StereoSide& left, const StereoSide& right) {
  const ImageBuffer& image = left.pyramid.level(0);
  RowIndex right_rows(image.height);
  right_rows.Fill(right.keypoints);
  const auto anywhere = static_cast<float>(image.width);
  int partners = 0, at_one_place = 0, ahead = 0, behind = 0;
  for (size_t i = 0; i < left.keypoints.size(); ++i) {
    const OrbKeypoint& k = left.keypoints[i];
    const float rows = kRows * left.pyramid.scale_y(k.level);
    const int best = UnmistakablePartner(left, i, right, right_rows, {rows, -anywhere, anywhere});
    if (best < 0) continue;
    const OrbKeypoint& partner = right.keypoints[static_cast<size_t>(best)];
    const float disparity = k.u - partner.u;
    const float offset = kOffset * left.pyramid.scale_x(k.level);
    ++partners;
    at_one_place += std::hypot(disparity, k.v - partner.v) < kOnePlace;
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

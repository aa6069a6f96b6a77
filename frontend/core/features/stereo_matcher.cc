#include "frontend/core/features/stereo_matcher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "frontend/core/features/disparity_refiner.h"
#include "frontend/core/features/pixel_kernels.h"

namespace gw::frontend {
namespace {

constexpr int kMaxHamming = 75;     // of 256; ORB-SLAM3's value
constexpr float kRowTolerance = 2;  // px of the coarser level
constexpr int kPatchRadius = 5;     // 11x11, px of the left feature's level
constexpr int kSearch = 5;          // px of the left feature's level, to either side
constexpr size_t kSampleEvery = 4;  // features whose row is checked
constexpr int kSampleLevels = 4;    // of the finest levels
constexpr float kSampleReach = 8;   // px of the level

static_assert(PixelKernels::kPatchSide == 2 * kPatchRadius + 1);
static_assert(PixelKernels::kShifts == 2 * kSearch + 1);

}  // namespace

StereoMatcher::StereoMatcher(const RectifiedCamera& camera)
    : max_disparity_(static_cast<float>(camera.bf() / camera.depth_min_m)),
      right_rows_(camera.height) {}

int StereoMatcher::MostSimilar(const StereoSide& left, size_t i, const StereoSide& right) const {
  const OrbKeypoint& k = left.keypoints[i];
  const float max_scale =
      left.pyramid.scale_y(std::min<int>(k.level + kMaxLevelStep, left.pyramid.num_levels() - 1));
  const float reach = kRowTolerance * max_scale;
  int best_distance = kMaxHamming;
  int best = -1;
  for (const RowIndex::Entry& r : right_rows_.Near(k.v, reach)) {
    if (std::abs(r.level - k.level) > kMaxLevelStep) continue;
    const float coarser = right.pyramid.scale_y(std::max<int>(r.level, k.level));
    if (std::abs(r.v - k.v) > kRowTolerance * coarser) continue;
    const float disparity = k.u - r.u;
    if (disparity < -kRowTolerance * coarser || disparity > max_disparity_) continue;
    const int distance =
        HammingDistance(left.descriptors[i], right.descriptors[static_cast<size_t>(r.index)]);
    if (distance < best_distance) {
      best_distance = distance;
      best = r.index;
    }
  }
  return best;
}

std::optional<float> StereoMatcher::Measure(const StereoSide& left, const OrbKeypoint& k,
                                            const StereoSide& right,
                                            const OrbKeypoint& partner) const {
  const float scale = left.pyramid.scale_x(k.level);
  const ImageBuffer& left_image = left.pyramid.level(k.level);
  const ImageBuffer& right_image = right.pyramid.level(k.level);
  const int x = static_cast<int>(std::lround(k.x));
  const int y = static_cast<int>(std::lround(k.y));
  const int start = static_cast<int>(std::lround((partner.u + 0.5f) / scale - 0.5f));
  constexpr int kReach = kSearch + kPatchRadius;
  if (start < kReach || start + kReach >= right_image.width) return std::nullopt;
  std::array<int, 2 * kSearch + 1> cost;
  BestPixelKernels().patch_differences(
      left_image.row(y - kPatchRadius) + x - kPatchRadius, left_image.stride,
      right_image.row(y - kPatchRadius) + start - kReach, right_image.stride, cost.data());
  const auto minimum = std::min_element(cost.begin(), cost.end());
  if (minimum == cost.begin() || minimum == cost.end() - 1) return std::nullopt;
  // Two lines of opposite slope through the minimum and its neighbours: the shape of a sum of
  // absolute differences.
  const auto before = static_cast<float>(minimum[-1]);
  const auto at = static_cast<float>(minimum[0]);
  const auto after = static_cast<float>(minimum[1]);
  const float slope = std::max(before, after) - at;
  const float step = slope > 0 ? 0.5f * (before - after) / slope : 0.0f;
  const float x_right =
      static_cast<float>(start - kSearch + static_cast<int>(minimum - cost.begin())) + step;
  const std::optional<float> disparity =
      RefineDisparity(left.pyramid.level(0), right.pyramid.level(0), k.u, k.v,
                      (static_cast<float>(x) - x_right) * scale);
  // A far point's disparity may come out slightly below zero.
  if (!disparity || *disparity > max_disparity_ || *disparity < -scale) return std::nullopt;
  return std::max(*disparity, 0.0f);
}

void StereoMatcher::Match(const StereoSide& left, const StereoSide& right,
                          std::vector<float>* disparities) {
  const size_t num_left = left.keypoints.size();
  disparities->assign(num_left, -1.0f);
  right_rows_.Fill(right.keypoints);
  for (size_t i = 0; i < num_left; ++i) {
    const int best = MostSimilar(left, i, right);
    if (best < 0) continue;
    (*disparities)[i] =
        Measure(left, left.keypoints[i], right, right.keypoints[static_cast<size_t>(best)])
            .value_or(-1.0f);
  }
}

void StereoMatcher::MeasureRowOffsets(const StereoSide& left, const StereoSide& right,
                                      std::vector<FeatureFrame::RowOffset>* out) const {
  out->clear();
  for (size_t i = 0; i < left.keypoints.size(); i += kSampleEvery) {
    const OrbKeypoint& k = left.keypoints[i];
    if (k.level >= kSampleLevels) continue;
    const float reach = kSampleReach * left.pyramid.scale_y(k.level);
    const int best =
        UnmistakablePartner(left, i, right, right_rows_, {reach, -reach, max_disparity_ + reach});
    if (best < 0) continue;
    out->push_back({static_cast<int>(i), right.keypoints[static_cast<size_t>(best)].v - k.v});
  }
}

}  // namespace gw::frontend

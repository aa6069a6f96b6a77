#include "frontend/core/features/stereo_matcher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

#include "frontend/core/features/disparity_refiner.h"
#include "frontend/core/features/pixel_kernels.h"

namespace gw::frontend {
namespace {

constexpr int kMaxHamming = 75;     // of 256; ORB-SLAM3's value
constexpr int kMaxLevelStep = 1;    // pyramid levels between the two detections of a point
constexpr float kRowTolerance = 2;  // px of the coarser level
constexpr int kPatchRadius = 5;     // 11x11, px of the left feature's level
constexpr int kSearch = 5;          // px of the left feature's level, to either side
constexpr size_t kSampleEvery = 4;  // features whose row is checked
constexpr int kSampleLevels = 4;    // of the finest levels
constexpr float kSampleReach = 8;   // px of the level
constexpr int kUnmistakable = 50;   // of 256 bits, and 0.8 of the second best

static_assert(PixelKernels::kPatchSide == 2 * kPatchRadius + 1);
static_assert(PixelKernels::kShifts == 2 * kSearch + 1);

}  // namespace

StereoMatcher::StereoMatcher(const RectifiedCamera& camera)
    : max_disparity_(static_cast<float>(camera.bf() / camera.depth_min_m)),
      height_(camera.height) {}

// Counting sort of the right keypoints by row.
void StereoMatcher::SortByRow(const std::vector<OrbKeypoint>& right) {
  row_begin_.assign(static_cast<size_t>(height_) + 1, 0);
  const auto row_of = [this](const OrbKeypoint& k) {
    return static_cast<size_t>(std::clamp(static_cast<int>(std::lround(k.v)), 0, height_ - 1));
  };
  for (const OrbKeypoint& k : right) ++row_begin_[row_of(k) + 1];
  for (size_t y = 0; y < static_cast<size_t>(height_); ++y) row_begin_[y + 1] += row_begin_[y];
  by_row_.resize(right.size());
  for (size_t j = right.size(); j-- > 0;) {
    // Filled from the back; afterwards row_begin_[y + 1] is the begin of row y.
    const OrbKeypoint& k = right[j];
    by_row_[static_cast<size_t>(--row_begin_[row_of(k) + 1])] = {k.u, k.v, k.level,
                                                                 static_cast<int>(j)};
  }
  row_begin_.erase(row_begin_.begin());
  row_begin_.push_back(static_cast<int>(right.size()));
}

int StereoMatcher::MostSimilar(const StereoSide& left, size_t i, const StereoSide& right) const {
  const OrbKeypoint& k = left.keypoints[i];
  const float max_scale =
      left.pyramid.scale_y(std::min<int>(k.level + kMaxLevelStep, left.pyramid.num_levels() - 1));
  const float reach = kRowTolerance * max_scale;
  const int first_row = std::clamp(static_cast<int>(std::floor(k.v - reach)), 0, height_ - 1);
  const int last_row = std::clamp(static_cast<int>(std::ceil(k.v + reach)), 0, height_ - 1);
  int best_distance = kMaxHamming;
  int best = -1;
  for (const InRow& r : InRows(first_row, last_row)) {
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
  SortByRow(right.keypoints);
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
    const int first_row = std::clamp(static_cast<int>(k.v - reach), 0, height_ - 1);
    const int last_row = std::clamp(static_cast<int>(k.v + reach), 0, height_ - 1);
    int best = -1;
    int distance = kUnmistakable + 1;
    int second = 257;
    for (const InRow& r : InRows(first_row, last_row)) {
      if (std::abs(r.level - k.level) > kMaxLevelStep) continue;
      if (k.u - r.u < -reach || k.u - r.u > max_disparity_ + reach) continue;
      const int d =
          HammingDistance(left.descriptors[i], right.descriptors[static_cast<size_t>(r.index)]);
      if (d < distance) {
        second = best < 0 ? second : distance;
        distance = d;
        best = r.index;
      } else if (d < second) {
        second = d;
      }
    }
    // The same corner found at another level of the pyramid is no rival, but rarely is as similar.
    if (best < 0 || distance * 5 > second * 4) continue;
    out->push_back({static_cast<int>(i), right.keypoints[static_cast<size_t>(best)].v - k.v});
  }
}

}  // namespace gw::frontend

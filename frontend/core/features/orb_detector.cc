#include "frontend/core/features/orb_detector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "common/core/check.h"
#include "frontend/core/features/pixel_kernels.h"

namespace gw::frontend {
namespace {

constexpr int kCell = 32;      // px of the level; a cell should be able to hold several patches
constexpr int kMinInCell = 3;  // fewer strong corners than this: weak ones count too

}  // namespace

int FastScore(const ImageBuffer& image, int x, int y) {
  uint8_t score = 0;
  ScalarPixelKernels().fast_scores(image.row(y) + x, image.stride, 0, 1, &score);
  return score;
}

CornerOffset RefineCorner(const ImageBuffer& image, int x, int y) {
  constexpr int kRadius = 2;
  constexpr int kRow = 8;
  alignas(32) std::array<uint8_t, 8 * kRow> scores;
  BestPixelKernels().fast_scores_5x5(image.row(y - kRadius) + x - kRadius, image.stride,
                                     scores.data());
  int64_t sum = 0;
  int64_t sum_x = 0;
  int64_t sum_y = 0;
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    for (int dx = -kRadius; dx <= kRadius; ++dx) {
      const int64_t score = scores[(dy + kRadius) * kRow + dx + kRadius];
      const int64_t weight = score * score * score;
      sum += weight;
      sum_x += weight * dx;
      sum_y += weight * dy;
    }
  }
  if (sum == 0) return {};
  return {static_cast<float>(sum_x) / static_cast<float>(sum),
          static_cast<float>(sum_y) / static_cast<float>(sum)};
}

double CornerRatio(const ImageBuffer& image, int x, int y) {
  const StructureTensor t = BestPixelKernels().structure_tensor(image.row(y) + x, image.stride);
  const double half_sum = 0.5 * (t.xx + t.yy);
  if (half_sum == 0) return 0;
  const double half_difference = 0.5 * (t.xx - t.yy);
  // The squares are exact.
  const double root =
      std::sqrt(half_difference * half_difference + static_cast<double>(t.xy) * t.xy);
  return std::max(0.0, half_sum - root) / (half_sum + root);
}

OrbDetector::OrbDetector(int threshold, int threshold_low, int border)
    : threshold_(threshold), threshold_low_(threshold_low), border_(border) {
  GW_CHECK(border >= 4 && 0 < threshold_low && threshold_low <= threshold && threshold < 255);
}

void OrbDetector::Detect(const ImageBuffer& level, std::vector<Corner>* corners) {
  corners->clear();
  const int width = level.width - 2 * border_;  // of the part where corners may lie
  const int height = level.height - 2 * border_;
  if (width <= 0 || height <= 0) return;
  const PixelKernels& kernels = BestPixelKernels();
  const size_t row_size = static_cast<size_t>(level.width) + 2 * PixelKernels::kSlack;
  scores_.resize(3 * row_size);
  peaks_.resize(static_cast<size_t>(width));
  const auto scores_of = [&](int y) {
    return scores_.data() + static_cast<size_t>(y % 3) * row_size;
  };
  // One px wider than where corners may lie, for the comparison with neighbours.
  const auto score_row = [&](int y) {
    kernels.fast_scores(level.row(y) + border_ - 1, level.stride, threshold_low_, width + 2,
                        scores_of(y) + border_ - 1);
  };
  score_row(border_ - 1);
  score_row(border_);
  for (int y = border_; y < level.height - border_; ++y) {
    score_row(y + 1);
    const uint8_t* at = scores_of(y);
    const int found = kernels.peaks(scores_of(y - 1), at, scores_of(y + 1), border_,
                                    border_ + width, peaks_.data());
    for (const int16_t x : std::span(peaks_.data(), static_cast<size_t>(found))) {
      corners->push_back({x, static_cast<int16_t>(y), at[x]});
    }
  }

  if (threshold_low_ == threshold_) return;
  const int columns = (width + kCell - 1) / kCell;
  const int rows = (height + kCell - 1) / kCell;
  count_.assign(static_cast<size_t>(columns) * static_cast<size_t>(rows), 0);
  const auto cell_of = [&](const Corner& c) {
    const int cell = (c.y - border_) / kCell * columns + (c.x - border_) / kCell;
    return static_cast<size_t>(cell);
  };
  for (const Corner& c : *corners) count_[cell_of(c)] += c.score > threshold_;
  std::erase_if(*corners, [&](const Corner& c) {
    return c.score <= threshold_ && count_[cell_of(c)] >= kMinInCell;
  });
}

}  // namespace gw::frontend

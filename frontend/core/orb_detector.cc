#include "frontend/core/orb_detector.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>

#include "common/core/check.h"

namespace gw::frontend {
namespace {

constexpr int kCell = 32;      // px of the level; a cell should be able to hold several patches
constexpr int kCircle = 3;     // radius of the FAST circle
constexpr int kMinInCell = 3;  // fewer corners than this: ask again with the low threshold

}  // namespace

struct OrbDetector::Scratch {
  std::vector<cv::KeyPoint> found;
  std::vector<int> count;  // per cell
};

OrbDetector::OrbDetector(int threshold, int threshold_low, int border)
    : threshold_(threshold),
      threshold_low_(threshold_low),
      border_(border),
      scratch_(std::make_unique<Scratch>()) {
  GW_CHECK(border > kCircle && threshold_low <= threshold);
}
OrbDetector::~OrbDetector() = default;
OrbDetector::OrbDetector(OrbDetector&&) noexcept = default;
OrbDetector& OrbDetector::operator=(OrbDetector&&) noexcept = default;

void OrbDetector::Detect(const ImageBuffer& level, std::vector<Corner>* corners) {
  corners->clear();
  // The part of the level where corners may lie.
  const cv::Rect inner(border_, border_, level.width - 2 * border_, level.height - 2 * border_);
  if (inner.width <= 0 || inner.height <= 0) return;
  // Read-only: OpenCV has no view of constant pixels.
  const cv::Mat image(level.height, level.width, CV_8UC1, const_cast<uint8_t*>(level.pixels.data()),
                      static_cast<size_t>(level.stride));
  // FAST needs its circle around every pixel, and one more for the comparison with neighbours.
  constexpr int kMargin = kCircle + 1;
  const int columns = (inner.width + kCell - 1) / kCell;
  const int rows = (inner.height + kCell - 1) / kCell;
  std::vector<int>& count = scratch_->count;
  count.assign(static_cast<size_t>(columns) * static_cast<size_t>(rows), 0);
  const auto cell_of = [&](const Corner& c) {
    return static_cast<size_t>((c.y - border_) / kCell * columns + (c.x - border_) / kCell);
  };
  const auto detect = [&](const cv::Rect& area, int threshold) {
    const cv::Rect grown(area.x - kMargin, area.y - kMargin, area.width + 2 * kMargin,
                         area.height + 2 * kMargin);
    cv::FAST(image(grown), scratch_->found, threshold, true);
    for (const cv::KeyPoint& k : scratch_->found) {
      const int x = static_cast<int>(k.pt.x) + grown.x;
      const int y = static_cast<int>(k.pt.y) + grown.y;
      if (!area.contains(cv::Point(x, y))) continue;
      corners->push_back(
          {static_cast<int16_t>(x), static_cast<int16_t>(y), static_cast<int16_t>(k.response)});
    }
  };
  detect(inner, threshold_);
  if (threshold_low_ >= threshold_) return;
  for (const Corner& c : *corners) ++count[cell_of(c)];
  // What the high threshold finds in a cell, the low one finds again: drop it there.
  std::erase_if(*corners, [&](const Corner& c) { return count[cell_of(c)] < kMinInCell; });
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      if (count[static_cast<size_t>(j * columns + i)] >= kMinInCell) continue;
      const cv::Rect cell(inner.x + i * kCell, inner.y + j * kCell, kCell, kCell);
      detect(cell & inner, threshold_low_);
    }
  }
}

}  // namespace gw::frontend

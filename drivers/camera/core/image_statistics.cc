#include "drivers/camera/core/image_statistics.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "common/core/check.h"

namespace gw::camera {
namespace {

constexpr int kStep = 4;    // px between the pixels that MeasureBrightness looks at
constexpr int kRadius = 4;  // px, radius of the ring around a spot
constexpr int kCell = 32;   // px, width of a cell in which dots are counted
constexpr int kMinCellMean = 6, kMaxCellMean = 235;
// A spot must stand out by this many grey levels, and by this share of its surroundings (shot
// noise, texture).
constexpr int kMinContrast = 8;
constexpr int kContrastDivisor = 10;

class Spots {
 public:
  explicit Spots(const ImageView& image) : image_(image) {
    const int stride = image.stride;
    // The ring has eight directions at about kRadius.
    ring_ = {kRadius,        -kRadius,       kRadius * stride, -kRadius * stride,
             3 * stride + 3, 3 * stride - 3, -3 * stride + 3,  -3 * stride - 3};
  }

  // Gives +1 for a bright spot at this pixel, -1 for a dark one and 0 for none. x and y must lie at
  // least kRadius + 1 inside the image.
  int At(int x, int y) const {
    const uint8_t* p = image_.data + static_cast<ptrdiff_t>(y) * image_.stride + x;
    // For most pixels the first two comparisons decide.
    const int left = p[ring_[0]], right = p[ring_[1]];
    const int centre = *p;
    const bool bright = centre > std::max(left, right) + kMinContrast;
    const bool dark = centre < std::min(left, right) - kMinContrast;
    if (!bright && !dark) return 0;
    int low = 255, high = 0;
    for (const ptrdiff_t offset : ring_) {
      low = std::min<int>(low, p[offset]);
      high = std::max<int>(high, p[offset]);
    }
    const int level = Sum3x3(p);
    const int least = std::max(kMinContrast, (low + high) / 2 / kContrastDivisor);
    if (bright && level > 9 * (high + least) && IsExtreme(p, level, 1)) return 1;
    if (dark && level < 9 * (low - least) && IsExtreme(p, level, -1)) return -1;
    return 0;
  }

 private:
  int Sum3x3(const uint8_t* p) const {
    int sum = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      const uint8_t* row = p + static_cast<ptrdiff_t>(dy) * image_.stride;
      sum += row[-1] + row[0] + row[1];
    }
    return sum;
  }
  // Compares a pixel with its eight neighbours; of equal ones the last in reading order counts as
  // the extreme.
  bool IsExtreme(const uint8_t* p, int level, int sign) const {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (dx == 0 && dy == 0) continue;
        const int other = sign * Sum3x3(p + static_cast<ptrdiff_t>(dy) * image_.stride + dx);
        const bool later = dy > 0 || (dy == 0 && dx > 0);
        if (later ? other >= sign * level : other > sign * level) return false;
      }
    }
    return true;
  }

  const ImageView& image_;
  std::array<ptrdiff_t, 8> ring_{};
};

}  // namespace

Brightness MeasureBrightness(const ImageView& image) {
  GW_CHECK(!image.empty() && image.format == PixelFormat::kGray8);
  std::array<int64_t, 256> histogram{};
  int64_t count = 0, sum = 0;
  for (int y = kStep / 2; y < image.height; y += kStep) {
    const uint8_t* row = image.data + static_cast<ptrdiff_t>(y) * image.stride;
    for (int x = kStep / 2; x < image.width; x += kStep) {
      ++histogram[row[x]];
      sum += row[x];
      ++count;
    }
  }
  Brightness out;
  if (count == 0) return out;
  out.mean = static_cast<double>(sum) / static_cast<double>(count);
  out.saturated = static_cast<double>(histogram[255]) / static_cast<double>(count);
  int64_t below = 0;
  while (below + histogram[static_cast<size_t>(out.percentile_95)] <
         0.95 * static_cast<double>(count)) {
    below += histogram[static_cast<size_t>(out.percentile_95++)];
  }
  return out;
}

DotPattern FindDots(const ImageView& image) {
  GW_CHECK(image.format == PixelFormat::kGray8 && image.width >= 64 && image.height >= 64);
  const Spots spots(image);
  DotPattern out;
  int usable = 0, covered = 0;
  for (int top = kRadius + 1; top + kCell + kRadius + 1 <= image.height; top += kCell) {
    for (int left = kRadius + 1; left + kCell + kRadius + 1 <= image.width; left += kCell) {
      int bright = 0, sum = 0;
      for (int y = top; y < top + kCell; ++y) {
        const uint8_t* row = image.data + static_cast<ptrdiff_t>(y) * image.stride;
        for (int x = left; x < left + kCell; ++x) {
          sum += row[x];
          const int spot = spots.At(x, y);
          if (spot > 0) ++bright;
          if (spot < 0) ++out.dark;
        }
      }
      out.bright += bright;
      const int mean = sum / (kCell * kCell);
      if (bright == 0 && (mean < kMinCellMean || mean > kMaxCellMean)) continue;
      ++usable;
      if (bright > 0) ++covered;
    }
  }
  if (covered > 0) out.density = static_cast<double>(out.bright) / covered;
  out.covered = usable > 0 ? static_cast<double>(covered) / usable : 0;
  return out;
}

}  // namespace gw::camera

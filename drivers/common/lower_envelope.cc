#include "drivers/common/lower_envelope.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "common/core/check.h"

namespace gw {
namespace {

struct Vertex {
  double x, y;
};

double Slope(const Vertex& a, const Vertex& b) {
  return (b.y - a.y) / (b.x - a.x);
}

int64_t FloorDivide(int64_t a, int64_t b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

}  // namespace

void LowerEnvelope::Add(int64_t x, int64_t y) {
  const int64_t bin = FloorDivide(x, options_.bin);
  if (bins_.empty() || bins_.back().bin < bin) {
    bins_.push_back({bin, x, y});
  } else if (y < bins_.back().y) {
    bins_.back() = {bins_.back().bin, x, y};
  }
  while (bins_.front().bin <= bin - options_.num_bins) bins_.pop_front();
}

double LowerEnvelope::At(int64_t x) const {
  GW_CHECK(!empty());
  const Point origin = bins_.front();
  std::vector<Vertex> hull;
  double sum_x = 0;
  for (const Point& point : bins_) {
    const Vertex next{static_cast<double>(point.x - origin.x),
                      static_cast<double>(point.y - origin.y)};
    sum_x += next.x;
    while (hull.size() >= 2 &&
           Slope(hull[hull.size() - 2], hull.back()) >= Slope(hull.back(), next)) {
      hull.pop_back();
    }
    hull.push_back(next);
  }
  const double middle = sum_x / static_cast<double>(bins_.size());
  double slope = 0;
  for (size_t i = 1; i < hull.size(); ++i) {
    slope = Slope(hull[i - 1], hull[i]);
    if (hull[i].x >= middle) break;
  }
  slope = std::clamp(slope, -options_.max_slope, options_.max_slope);
  double intercept = std::numeric_limits<double>::infinity();
  for (const Vertex& vertex : hull) intercept = std::min(intercept, vertex.y - slope * vertex.x);
  return static_cast<double>(origin.y) + intercept + slope * static_cast<double>(x - origin.x);
}

}  // namespace gw

#include "grid/core/scan_evidence.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gw::grid {
namespace {

Index2 CellOf(const Eigen::Vector2d& p, double cell_m) {
  return {static_cast<int32_t>(std::floor(p.x() / cell_m)),
          static_cast<int32_t>(std::floor(p.y() / cell_m))};
}

// A square of cells around the camera's foot, with the evidence in it.
class Window {
 public:
  Window(const Eigen::Vector2d& centre, double radius, double cell_m) : cell_m_(cell_m) {
    const Eigen::Vector2d reach(radius, radius);
    begin_ = CellOf(centre - reach, cell_m);
    const Index2 last = CellOf(centre + reach, cell_m);
    width_ = last.x - begin_.x + 1;
    height_ = last.y - begin_.y + 1;
    evidence_.assign(static_cast<size_t>(width_) * static_cast<size_t>(height_), Cell{});
  }

  int width() const { return width_; }
  int height() const { return height_; }
  Index2 begin() const { return begin_; }
  Eigen::Vector2d Centre(int x, int y) const {
    return {(begin_.x + x + 0.5) * cell_m_, (begin_.y + y + 0.5) * cell_m_};
  }
  Cell& at(int x, int y) {
    return evidence_[static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)];
  }
  void Hit(const Eigen::Vector2d& p, float sharpness) {
    const Index2 index = CellOf(p, cell_m_);
    const int x = index.x - begin_.x, y = index.y - begin_.y;
    if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
    Cell& cell = at(x, y);
    cell = {Cell::kHit, std::max(cell.sharpness, sharpness)};
  }

 private:
  double cell_m_;
  Index2 begin_;
  int width_ = 0, height_ = 0;
  std::vector<Cell> evidence_;
};

// Was the floor seen at this range in at least half of the bearings that the cell fills?
bool FloorSeen(const FloorScan& scan, float range, float bearing, double cell_m) {
  const auto half = static_cast<float>(cell_m / 2) / std::max(range, 1e-3f);
  const float at = (bearing - scan.first_bearing) / scan.bearing_step;
  const float reach = half / scan.bearing_step;
  const int first = std::max(0, static_cast<int>(std::lround(at - reach)));
  const int last = std::min(scan.num_bearings - 1, static_cast<int>(std::lround(at + reach)));
  int seen = 0;
  for (int bin = first; bin <= last; ++bin) {
    const auto stretches = scan.FreeAt(bin);
    seen += std::any_of(stretches.begin(), stretches.end(),
                        [range](const auto& s) { return s.from <= range && range <= s.to; });
  }
  return last >= first && 2 * seen > last - first;
}

// Into the turn around the middle of the view.
float Unwrapped(double bearing, const FloorScan& scan) {
  const double middle = scan.bearing(scan.num_bearings / 2);
  return static_cast<float>(middle + std::remainder(bearing - middle, 2 * std::numbers::pi));
}

}  // namespace

std::vector<CellEvidence> EvidenceOf(const FloorScan& scan, const Pose2& T_LB, double cell_m,
                                     double footprint_m) {
  const Eigen::Vector2d origin = scan.origin.cast<double>();
  const Pose2 T_BL = T_LB.inverse();
  Window window(T_LB * origin, scan.max_range + origin.norm() + footprint_m, cell_m);
  for (int bin = 0; bin < scan.num_bearings; ++bin) {
    const double bearing = scan.bearing(bin);
    const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing));
    for (const FloorScan::Hit& hit : scan.HitsAt(bin)) {
      // Share of the cell in the variance: 1 for a depth without noise.
      const double cell_variance = cell_m * cell_m / 4;
      const double variance = static_cast<double>(hit.sigma) * static_cast<double>(hit.sigma);
      window.Hit(T_LB * (origin + direction * static_cast<double>(hit.range)),
                 static_cast<float>(cell_variance / (cell_variance + variance)));
    }
  }
  for (int y = 0; y < window.height(); ++y) {
    for (int x = 0; x < window.width(); ++x) {
      if (window.at(x, y).log_odds != 0) continue;
      const Eigen::Vector2d p_B = T_BL * window.Centre(x, y);
      const Eigen::Vector2d ray = p_B - origin;
      const auto range = static_cast<float>(ray.norm());
      const bool under_robot = p_B.norm() <= footprint_m;
      if (!under_robot &&
          (range > scan.max_range ||
           !FloorSeen(scan, range, Unwrapped(std::atan2(ray.y(), ray.x()), scan), cell_m))) {
        continue;
      }
      window.at(x, y).log_odds = Cell::kMiss;
    }
  }
  std::vector<CellEvidence> out;
  for (int y = 0; y < window.height(); ++y) {
    for (int x = 0; x < window.width(); ++x) {
      if (window.at(x, y).log_odds == 0) continue;
      out.push_back({{window.begin().x + x, window.begin().y + y}, window.at(x, y)});
    }
  }
  return out;
}

}  // namespace gw::grid

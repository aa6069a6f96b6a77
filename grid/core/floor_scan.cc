#include "grid/core/floor_scan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gw::grid {
namespace {

constexpr int kMaxBearings = 320;  // over the camera's view: a cell of 5 cm at 10 m
// Pixels of one bearing that must agree on a thing. A single one is noise now and then.
constexpr size_t kLeastSupport = 3;
// A hole is believed less easily: mirrors in the floor look like it.
constexpr size_t kLeastHoleSupport = 6;
constexpr double kBlurredCells = 2;
constexpr float kRowsWithoutDepth = 3.5f;  // that do not interrupt a seen floor
constexpr float kNearest = 0.3f;           // m: of rays that look up, what matters at this distance

}  // namespace

FloorScanner::FloorScanner(const DepthRays& rays, const GridConfig& config)
    : config_(config),
      camera_height_(rays.origin.z()),
      sigma_per_m2_(static_cast<float>(rays.sigma_per_m2)),
      row_slope_(0) {
  const auto top = static_cast<float>(config.robot_height_m);
  const float steepest = std::max(0.0f, top - camera_height_) / kNearest;
  // Bearings count from the optical axis, so that none of the view lies at the seam of +-pi.
  const size_t centre = static_cast<size_t>(rays.height / 2) * static_cast<size_t>(rays.width) +
                        static_cast<size_t>(rays.width / 2);
  const Eigen::Vector3f& axis = rays.ray[centre];
  const float heading = std::atan2(axis.y(), axis.x());
  std::vector<std::pair<float, Pixel>> seen;
  for (size_t i = 0; i < rays.ray.size(); ++i) {
    const Eigen::Vector3f& ray = rays.ray[i];
    const float length = std::hypot(ray.x(), ray.y());
    const Pixel pixel{static_cast<int>(i), length, ray.z()};
    if (length <= 0 || pixel.slope() > steepest) continue;
    float bearing = std::atan2(ray.y(), ray.x()) - heading;
    if (bearing > std::numbers::pi_v<float>) bearing -= 2 * std::numbers::pi_v<float>;
    if (bearing < -std::numbers::pi_v<float>) bearing += 2 * std::numbers::pi_v<float>;
    seen.emplace_back(bearing, pixel);
  }
  const size_t below = centre + static_cast<size_t>(rays.width);
  const auto slope_of = [&](size_t i) {
    return rays.ray[i].z() / std::hypot(rays.ray[i].x(), rays.ray[i].y());
  };
  row_slope_ = slope_of(centre) - slope_of(below);

  float least = 0, most = 0;
  for (const auto& [bearing, pixel] : seen) {
    least = std::min(least, bearing);
    most = std::max(most, bearing);
  }
  // No bearing may be narrower than the widest column, or it would see nothing.
  const Eigen::Vector3f& beside = rays.ray[centre + 1];
  const float column = std::abs(std::atan2(beside.y(), beside.x()) - heading);
  const int bins = std::clamp(static_cast<int>((most - least) / column), 1, kMaxBearings);
  empty_.origin = rays.origin.head<2>();
  empty_.num_bearings = bins;
  empty_.bearing_step = std::max(1e-6f, (most - least) / static_cast<float>(bins));
  empty_.first_bearing = heading + least + empty_.bearing_step / 2;
  empty_.max_range = static_cast<float>(config.max_range_m);

  std::vector<std::vector<Pixel>> by_bin(static_cast<size_t>(bins));
  for (const auto& [bearing, pixel] : seen) {
    const int bin = static_cast<int>((bearing - least) / empty_.bearing_step);
    by_bin[static_cast<size_t>(std::clamp(bin, 0, bins - 1))].push_back(pixel);
  }
  for (std::vector<Pixel>& bin : by_bin) {
    std::stable_sort(bin.begin(), bin.end(),
                     [](const Pixel& a, const Pixel& b) { return a.slope() < b.slope(); });
    pixel_begin_.push_back(static_cast<int>(pixels_.size()));
    pixels_.insert(pixels_.end(), bin.begin(), bin.end());
  }
  pixel_begin_.push_back(static_cast<int>(pixels_.size()));
}

FloorScan FloorScanner::Scan(const DepthImage& depth) const {
  FloorScan scan = empty_;
  for (size_t bin = 0; bin < static_cast<size_t>(scan.num_bearings); ++bin) {
    scan.free_begin.push_back(static_cast<int>(scan.free.size()));
    scan.hit_begin.push_back(static_cast<int>(scan.hits.size()));
    const auto begin = static_cast<size_t>(pixel_begin_[bin]);
    const auto end = static_cast<size_t>(pixel_begin_[bin + 1]);
    ScanBearing(std::span(pixels_).subspan(begin, end - begin), depth, &scan);
  }
  scan.free_begin.push_back(static_cast<int>(scan.free.size()));
  scan.hit_begin.push_back(static_cast<int>(scan.hits.size()));
  return scan;
}

void FloorScanner::ScanBearing(std::span<const Pixel> pixels, const DepthImage& depth,
                               FloorScan* scan) const {
  const auto step = static_cast<float>(config_.step_m);
  const auto tilt = static_cast<float>(std::tan(config_.tilt_deg * std::numbers::pi / 180));
  const auto top = static_cast<float>(config_.robot_height_m);
  const size_t first_free = scan->free.size();
  const size_t first_hit = scan->hits.size();
  std::vector<Point> standing, holes;
  float floor_slope = -1e9f;  // of the floor pixel before
  for (const Pixel& pixel : pixels) {
    const float z = depth[static_cast<size_t>(pixel.index)];
    if (z <= 0) continue;
    const float range = z * pixel.range_per_depth;
    const float height = camera_height_ + z * pixel.height_per_depth;
    const float limit = step + range * tilt;
    const float sigma = sigma_per_m2_ * z * z * pixel.range_per_depth;
    if (height < -limit) {
      const float edge = -camera_height_ / pixel.slope();               // where the floor should be
      const float spacing = edge * edge * row_slope_ / camera_height_;  // of rows on the floor
      if (edge <= scan->max_range) holes.push_back({edge, 0.6f * spacing});
    } else if (height > top || range > scan->max_range) {
      continue;
    } else if (height > limit) {
      standing.push_back({range, sigma});
    } else if (pixel.slope() - floor_slope <= kRowsWithoutDepth * row_slope_) {
      scan->free.back().from = std::min(scan->free.back().from, range);
      scan->free.back().to = std::max(scan->free.back().to, range);
      floor_slope = pixel.slope();
    } else {
      scan->free.push_back({range, range});
      floor_slope = pixel.slope();
    }
  }
  TrimFree(first_free, scan);
  AddHits(&standing, kLeastSupport, scan);
  AddHits(&holes, kLeastHoleSupport, scan);
  CutFree(first_free, first_hit, scan);
  DropBlurred(first_hit, scan);
}

void FloorScanner::AddHits(std::vector<Point>* points, size_t least_support,
                           FloorScan* scan) const {
  std::sort(points->begin(), points->end(),
            [](const Point& a, const Point& b) { return a.range < b.range; });
  const auto cell = static_cast<float>(config_.cell_m);
  size_t begin = 0;
  while (begin < points->size()) {
    const auto at = [&](size_t i) { return (*points)[i].range; };
    size_t end = begin + 1;
    while (end < points->size() &&
           at(end) - at(end - 1) <= std::max(cell, 2 * (*points)[end].sigma)) {
      ++end;
    }
    const size_t count = end - begin;
    if (count >= least_support) {
      const float near = at(begin + count / 10), far = at(end - 1 - count / 10);
      const Point& middle = (*points)[begin + count / 2];
      // A standing face is as deep as the noise; what is deeper is seen from above, or slanted.
      if (far - near <= std::max(cell, 3 * middle.sigma)) {
        scan->hits.push_back({middle.range, middle.sigma});
      } else {
        for (float range = near; range < far + cell / 2; range += cell) {
          scan->hits.push_back({range, middle.sigma});
        }
      }
    }
    begin = end;
  }
}

void FloorScanner::TrimFree(size_t first_free, FloorScan* scan) const {
  const auto begin = scan->free.begin() + static_cast<ptrdiff_t>(first_free);
  for (auto it = begin; it != scan->free.end(); ++it) {
    it->to -= 3 * sigma_per_m2_ * it->to * it->to;
  }
  scan->free.erase(std::remove_if(begin, scan->free.end(),
                                  [](const FloorScan::Stretch& s) { return s.to < s.from; }),
                   scan->free.end());
}

void FloorScanner::DropBlurred(size_t first_hit, FloorScan* scan) const {
  const auto limit = static_cast<float>(kBlurredCells * config_.cell_m);
  const auto begin = scan->hits.begin() + static_cast<ptrdiff_t>(first_hit);
  scan->hits.erase(std::remove_if(begin, scan->hits.end(),
                                  [limit](const FloorScan::Hit& hit) { return hit.sigma > limit; }),
                   scan->hits.end());
}

void FloorScanner::CutFree(size_t first_free, size_t first_hit, FloorScan* scan) const {
  std::vector<FloorScan::Stretch> left(scan->free.begin() + static_cast<ptrdiff_t>(first_free),
                                       scan->free.end());
  const auto cell = static_cast<float>(config_.cell_m);
  for (size_t i = first_hit; i < scan->hits.size(); ++i) {
    const float range = scan->hits[i].range;
    const float margin = cell + 2 * scan->hits[i].sigma;
    std::vector<FloorScan::Stretch> cut;
    for (const FloorScan::Stretch& s : left) {
      if (s.from < range - margin) cut.push_back({s.from, std::min(s.to, range - margin)});
      if (s.to > range + margin) cut.push_back({std::max(s.from, range + margin), s.to});
    }
    left = std::move(cut);
  }
  scan->free.resize(first_free);
  scan->free.insert(scan->free.end(), left.begin(), left.end());
}

}  // namespace gw::grid

#include "tools/robot/floorplan/floor_map.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace gw::floorplan {
namespace {

// Distance (m) to the nearest cell whose mark is not 0.
std::vector<float> DistanceToMarked(const FloorMap& map, const std::vector<uint8_t>& marks,
                                    double limit) {
  cv::Mat open(map.height, map.width, CV_8U);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      open.at<uint8_t>(y, x) = marks[map.index(x, y)] != 0 ? 0 : 255;
    }
  }
  cv::Mat distance;
  cv::distanceTransform(open, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  std::vector<float> out(marks.size());
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      // The transform measures to the centre of the marked cell.
      const double d = std::max(0.0, distance.at<float>(y, x) - 0.5) * map.resolution;
      out[map.index(x, y)] = static_cast<float>(std::min(d, limit));
    }
  }
  return out;
}

}  // namespace

Eigen::Vector2i FloorMap::CellOf(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d cell = (p - origin) / resolution;
  return {static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y()))};
}

std::vector<float> DistanceToOccupied(const FloorMap& map, double limit) {
  return DistanceToMarked(map, map.occupied, limit);
}

std::vector<float> DistanceToNotFree(const FloorMap& map, double limit) {
  std::vector<uint8_t> marks = map.occupied;
  for (size_t i = 0; i < map.unknown.size(); ++i) marks[i] |= map.unknown[i];
  return DistanceToMarked(map, marks, limit);
}

double DistanceAt(const FloorMap& map, const std::vector<float>& distance,
                  const Eigen::Vector2d& p) {
  const Eigen::Vector2d at = (p - map.origin) / map.resolution - Eigen::Vector2d(0.5, 0.5);
  const int x = static_cast<int>(std::floor(at.x()));
  const int y = static_cast<int>(std::floor(at.y()));
  const double fx = at.x() - x, fy = at.y() - y;
  const auto value = [&](int ix, int iy) {
    ix = std::clamp(ix, 0, map.width - 1);
    iy = std::clamp(iy, 0, map.height - 1);
    return static_cast<double>(distance[map.index(ix, iy)]);
  };
  return (1 - fy) * ((1 - fx) * value(x, y) + fx * value(x + 1, y)) +
         fy * ((1 - fx) * value(x, y + 1) + fx * value(x + 1, y + 1));
}

std::vector<uint8_t> ReachableCells(const FloorMap& map, const Eigen::Vector2d& from) {
  std::vector<uint8_t> reachable(map.occupied.size(), 0);
  const Eigen::Vector2i start = map.CellOf(from);
  if (!map.InMap(start.x(), start.y()) || map.Occupied(start.x(), start.y())) return reachable;
  std::vector<Eigen::Vector2i> open = {start};
  reachable[map.index(start.x(), start.y())] = 1;
  while (!open.empty()) {
    const Eigen::Vector2i cell = open.back();
    open.pop_back();
    for (const auto& step : {Eigen::Vector2i(1, 0), Eigen::Vector2i(-1, 0), Eigen::Vector2i(0, 1),
                             Eigen::Vector2i(0, -1)}) {
      const Eigen::Vector2i next = cell + step;
      if (!map.InMap(next.x(), next.y()) || map.Occupied(next.x(), next.y())) continue;
      uint8_t& mark = reachable[map.index(next.x(), next.y())];
      if (mark != 0) continue;
      mark = 1;
      open.push_back(next);
    }
  }
  return reachable;
}

}  // namespace gw::floorplan

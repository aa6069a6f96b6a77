#include "tools/robot/explore/frontiers.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace gw::explore {
namespace {

using floorplan::FloorMap;

// A free cell beside which (at one of four sides) nothing is known.
bool IsFrontier(const FloorMap& map, const std::vector<uint8_t>& open, int x, int y) {
  if (map.Occupied(x, y) || map.Unknown(x, y) || open[map.index(x, y)] != 0) return false;
  const auto is_open = [&](int nx, int ny) {
    return map.InMap(nx, ny) && open[map.index(nx, ny)] != 0;
  };
  return is_open(x - 1, y) || is_open(x + 1, y) || is_open(x, y - 1) || is_open(x, y + 1);
}

Eigen::Vector2d MiddleOf(const FloorMap& map, const std::vector<int>& cells) {
  const auto centre = [&map](int cell) { return map.CentreOf(cell % map.width, cell / map.width); };
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const int cell : cells) mean += centre(cell) / static_cast<double>(cells.size());
  Eigen::Vector2d nearest = centre(cells.front());
  for (const int cell : cells) {
    const Eigen::Vector2d p = centre(cell);
    if ((p - mean).squaredNorm() < (nearest - mean).squaredNorm()) nearest = p;
  }
  return nearest;
}

}  // namespace

std::vector<Frontier> FindFrontiers(const UnseenFloor& floor) {
  const FloorMap& map = floor.map;
  if (map.occupied.empty()) return {};
  cv::Mat edge = cv::Mat::zeros(map.height, map.width, CV_8U);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      if (IsFrontier(map, floor.open, x, y)) edge.at<uint8_t>(y, x) = 1;
    }
  }
  cv::Mat label;
  const int count = cv::connectedComponents(edge, label, 8, CV_32S);
  std::vector<Frontier> frontiers(static_cast<size_t>(count));
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      if (edge.at<uint8_t>(y, x) == 0) continue;
      frontiers[static_cast<size_t>(label.at<int>(y, x))].cells.push_back(map.index(x, y));
    }
  }
  std::erase_if(frontiers, [&](const Frontier& f) {
    return f.cells.empty() ||
           static_cast<double>(f.cells.size()) * map.resolution < 2 * floor.robot_radius_m;
  });
  std::sort(frontiers.begin(), frontiers.end(),
            [](const Frontier& a, const Frontier& b) { return a.cells.front() < b.cells.front(); });
  for (Frontier& frontier : frontiers) frontier.middle = MiddleOf(map, frontier.cells);
  return frontiers;
}

}  // namespace gw::explore

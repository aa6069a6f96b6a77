#include "tools/robot/explore/unseen_floor.h"

#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace gw::explore {
namespace {

using floorplan::FloorMap;

// Cells that lie under the robot somewhere, if it can stand wherever nothing is occupied.
std::vector<uint8_t> CellsThatFit(const FloorMap& map, const std::vector<float>& to_occupied,
                                  double radius) {
  FloorMap places = map;
  for (size_t i = 0; i < to_occupied.size(); ++i) {
    places.occupied[i] = to_occupied[i] >= static_cast<float>(radius) ? 1 : 0;
  }
  const std::vector<float> to_place = floorplan::DistanceToOccupied(places, 2 * radius);
  std::vector<uint8_t> fit(to_place.size());
  for (size_t i = 0; i < fit.size(); ++i) {
    fit[i] = to_place[i] <= static_cast<float>(radius) ? 1 : 0;
  }
  return fit;
}

// Clears regions (8-connected) that are smaller than `least_m2`.
void DropSmallRegions(const FloorMap& map, double least_m2, std::vector<uint8_t>* open) {
  const cv::Mat cells(map.height, map.width, CV_8U, open->data());
  cv::Mat label, stats, centre;
  cv::connectedComponentsWithStats(cells, label, stats, centre, 8, CV_32S);
  const double least = least_m2 / (map.resolution * map.resolution);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const int region = label.at<int>(y, x);
      if (region == 0 || stats.at<int>(region, cv::CC_STAT_AREA) >= least) continue;
      (*open)[map.index(x, y)] = 0;
    }
  }
}

}  // namespace

UnseenFloor FindUnseenFloor(FloorMap map, std::vector<float> looked_at_m, const Sight& sight,
                            double robot_radius_m) {
  UnseenFloor out{std::move(map), {}, std::move(looked_at_m), sight, robot_radius_m};
  const size_t size = out.map.occupied.size();
  if (size == 0) return out;
  out.looked_at_m.resize(size, kNeverLookedAt);
  out.open = out.map.unknown;
  out.open.resize(size, 0);
  const std::vector<float> to_occupied =
      floorplan::DistanceToOccupied(out.map, 2 * std::max(kSeamM, robot_radius_m));
  const std::vector<uint8_t> fit = CellsThatFit(out.map, to_occupied, robot_radius_m);
  const auto given_up = static_cast<float>(sight.min_range_m / kNearer);
  for (size_t i = 0; i < size; ++i) {
    const bool seam = to_occupied[i] < static_cast<float>(kSeamM);
    if (seam || fit[i] == 0 || out.looked_at_m[i] <= given_up) out.open[i] = 0;
  }
  DropSmallRegions(out.map, std::numbers::pi * robot_radius_m * robot_radius_m, &out.open);
  return out;
}

}  // namespace gw::explore

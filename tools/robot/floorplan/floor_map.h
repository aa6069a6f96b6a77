// A floor map in the ROS map_server format: map.yaml (image, resolution, origin, thresholds) and an
// 8-bit grey image (PGM, PNG) whose white is 255. The map frame is the world frame of the
// simulator: x right, y up in the image, metres.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "common/core/result.h"

namespace gw::floorplan {

struct FloorMap {
  int width = 0, height = 0;                         // cells
  double resolution = 0;                             // m
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  // world coordinates of cell (0, 0)'s corner
  std::vector<uint8_t> occupied;                     // 1 or 0, row 0 is the lowest y

  int index(int x, int y) const { return y * width + x; }
  bool InMap(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  // Cells outside the map count as free: a map need not be closed by walls.
  bool Occupied(int x, int y) const { return InMap(x, y) && occupied[index(x, y)] != 0; }
  Eigen::Vector2i CellOf(const Eigen::Vector2d& p) const;
  Eigen::Vector2d CentreOf(int x, int y) const {
    return origin + resolution * Eigen::Vector2d(x + 0.5, y + 0.5);
  }
};

// A cell is occupied when its darkness, (255 - value) / 255 or with `negate` value / 255, is above
// occupied_thresh. Unknown cells count as free: what has no wall can be entered.
// Errors: kNotFound, kIo, kBadConfig (map.yaml, with the line), kBadData (image, no walls at all).
Result<FloorMap> LoadFloorMap(const std::string& yaml_path);

// Distance (m) from the centre of every cell to the nearest occupied cell's border; 0 inside.
// `limit` caps it, also where nothing is occupied.
std::vector<float> DistanceToOccupied(const FloorMap& map, double limit);

// Distance to the nearest obstacle at any point, interpolated between cell centres.
double DistanceAt(const FloorMap& map, const std::vector<float>& distance,
                  const Eigen::Vector2d& p);

// Cells that can be reached from `from` without crossing an occupied one (4-connected).
std::vector<uint8_t> ReachableCells(const FloorMap& map, const Eigen::Vector2d& from);

}  // namespace gw::floorplan

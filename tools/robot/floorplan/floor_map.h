// A floor map in the ROS map_server format (wiki.ros.org/map_server): map.yaml (image, resolution,
// origin, thresholds, mode) and an image (PGM, PNG). The map frame is the world frame of the
// simulator: x right, y up in an image whose origin has no yaw, metres.
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
  std::vector<uint8_t> unknown;                      // the same; empty: no cell is

  int index(int x, int y) const { return y * width + x; }
  bool InMap(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  // Cells outside the map count as free: a map need not be closed by walls.
  bool Occupied(int x, int y) const { return InMap(x, y) && occupied[index(x, y)] != 0; }
  bool Unknown(int x, int y) const {
    return !unknown.empty() && InMap(x, y) && unknown[index(x, y)] != 0;
  }
  Eigen::Vector2i CellOf(const Eigen::Vector2d& p) const;
  Eigen::Vector2d CentreOf(int x, int y) const {
    return origin + resolution * Eigen::Vector2d(x + 0.5, y + 0.5);
  }
};

// The occupancy of a cell is its darkness, (255 - grey) / 255, or with `negate` grey / 255; with
// `mode: raw` the grey itself in per cent. Above occupied_thresh the cell is occupied, below
// free_thresh free, else unknown, also with `mode: scale`: a cell that may be occupied is not known
// to be free. Unknown as well, whatever the thresholds say: pixels that are not opaque, grey 205
// without `negate` (what map savers write for unknown, and ROS 2's free_thresh of 0.25 would call
// free), and with `mode: raw` what is above 100. A map in which no cell at all is free was drawn as
// walls alone: its unknown cells count as free. `free_thresh` defaults to map_server's 0.196. The
// image's path is absolute or relative to the folder of map.yaml. An origin with a yaw turns the
// map about the corner of its first cell; the map that is returned is upright.
// Errors: kNotFound, kIo, kBadConfig (map.yaml: every mistake with its line), kBadData (image, no
// walls at all).
Result<FloorMap> LoadFloorMap(const std::string& yaml_path);

// Distance (m) from the centre of every cell to the nearest occupied cell's border; 0 inside.
// `limit` caps it, also where nothing is occupied.
std::vector<float> DistanceToOccupied(const FloorMap& map, double limit);

// The same to the nearest cell that is occupied or unknown.
std::vector<float> DistanceToNotFree(const FloorMap& map, double limit);

// Distance to the nearest obstacle at any point, interpolated between cell centres.
double DistanceAt(const FloorMap& map, const std::vector<float>& distance,
                  const Eigen::Vector2d& p);

// Cells that can be reached from `from` without crossing an occupied one (4-connected).
std::vector<uint8_t> ReachableCells(const FloorMap& map, const Eigen::Vector2d& from);

}  // namespace gw::floorplan

// Outlines of the occupied cells of a floor map as clean polygons: a slanted or round wall becomes
// a few straight pieces, not a staircase of cells.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/robot/floorplan/floor_map.h"

namespace gw::floorplan {

// A closed outline; the occupied side is on the left of each edge, the free side on the right.
// The last vertex is joined to the first.
struct Contour {
  std::vector<Eigen::Vector2d> vertices;  // world, m
};

// Cells that touch at a corner only are one wall. Outlines are simplified by Douglas-Peucker
// (Cartographica 10, 1973) with `tolerance` metres, less for small ones; the steps of a slanted
// wall deviate by up to 1.42 cells from each other, so that a tolerance a little above removes
// them. Order and start of the outlines depend on the map alone.
std::vector<Contour> TraceContours(const FloorMap& map, double tolerance);

}  // namespace gw::floorplan

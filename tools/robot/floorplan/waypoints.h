// Places to visit, and in what order: the text files that belong to a floor map.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/core/result.h"

namespace gw::floorplan {

// In the frame of the map, m and rad.
struct Waypoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double yaw = 0;
};

// Reads `index x y theta` lines (# starts a comment), in order of index from 0, and a list of
// indices, one a line. Error kNotFound or kBadData with the line.
Result<std::vector<Waypoint>> LoadWaypoints(const std::string& path);
Result<std::vector<int>> LoadVisitOrder(const std::string& path, int num_waypoints);

// `visit` (empty: all waypoints in order) `laps` times, as indices of waypoints. Where a lap ends
// where it begins, the next begins there without a stop of its own. Precondition: laps >= 1.
std::vector<int> StopsOfLaps(int num_waypoints, std::vector<int> visit, int laps);

}  // namespace gw::floorplan

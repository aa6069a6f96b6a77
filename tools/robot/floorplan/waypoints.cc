#include "tools/robot/floorplan/waypoints.h"

#include <fstream>
#include <sstream>

namespace gw::floorplan {

Result<std::vector<Waypoint>> LoadWaypoints(const std::string& path) {
  std::ifstream in(path);
  if (!in) return Error{ErrorCode::kNotFound, path + ": cannot open the waypoint file"};
  std::vector<Waypoint> out;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    std::istringstream fields(line);
    double index = 0;
    Waypoint w;
    std::string rest;
    if (!(fields >> index >> w.position.x() >> w.position.y() >> w.yaw) || (fields >> rest) ||
        index != static_cast<double>(out.size())) {
      return Error{ErrorCode::kBadData, path + ":" + std::to_string(number) +
                                            ": want `index x y theta` with index " +
                                            std::to_string(out.size()) + ", got `" + line + "`"};
    }
    out.push_back(w);
  }
  if (out.empty()) return Error{ErrorCode::kBadData, path + ": holds no waypoint"};
  return out;
}

Result<std::vector<int>> LoadVisitOrder(const std::string& path, int num_waypoints) {
  std::ifstream in(path);
  if (!in)
    return Error{ErrorCode::kNotFound, path + ": cannot open the list of waypoints to visit"};
  std::vector<int> out;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    std::istringstream fields(line);
    int index = -1;
    std::string rest;
    if (!(fields >> index) || (fields >> rest) || index < 0 || index >= num_waypoints) {
      return Error{ErrorCode::kBadData,
                   path + ":" + std::to_string(number) + ": want the index of a waypoint, 0 to " +
                       std::to_string(num_waypoints - 1) + ", got `" + line + "`"};
    }
    out.push_back(index);
  }
  if (out.empty()) return Error{ErrorCode::kBadData, path + ": visits nothing"};
  return out;
}

std::vector<int> StopsOfLaps(int num_waypoints, std::vector<int> visit, int laps) {
  if (visit.empty()) {
    for (int i = 0; i < num_waypoints; ++i) visit.push_back(i);
  }
  std::vector<int> stops;
  const bool closed = !visit.empty() && visit.front() == visit.back();
  for (int lap = 0; lap < laps; ++lap) {
    stops.insert(stops.end(), visit.begin() + (lap > 0 && closed ? 1 : 0), visit.end());
  }
  return stops;
}

}  // namespace gw::floorplan

// gw-navigate: drives to the waypoints of a floor map, or explores the floor.
#include <opencv2/core.hpp>

#include "tools/robot/navigate/navigate_node.h"

int main(int argc, char** argv) {
  cv::setNumThreads(1);  // the other core is the front-end's
  gw::navigate::NavigateOptions o;
  return gw::process::RunProgram(
      argc, argv,
      {"gw-navigate",
       "Drives to the waypoints of a floor map, in order: POSE in, BASE_COMMAND out. Ends when all "
       "are reached or unreachable: exit 1 if any is unreachable.\n"
       "With --explore it needs no map: it drives on the floor map that gw-grid makes (GRID) until "
       "no frontier is left that it can look past, and back to where it began: exit 0, also when "
       "there are frontiers that it cannot reach; exit 1 when it could not set off or come back.\n"
       "The map and the world W of POSE are tied by --start: where on the map the robot stood, and "
       "where it looked, when W began (W has its origin and heading at the first body pose; a map "
       "on disk keeps its W)."},
      {{"--explore", &o.explore, "the floor that gw-grid does not know yet; no map, no waypoints"},
       {"--map", &o.map, "map.yaml of map_server"},
       {"--waypoints", &o.waypoints, "lines `index x y theta` (m, rad, on the map)"},
       {"--path", &o.path, "indices of waypoints to visit, one a line (default: all in order)"},
       {"--laps", &o.laps, "how often to visit them (default 1)"},
       {"--start", &o.start, "X,Y,THETA where W began (default: at the first stop)"},
       {"--record", &o.record, "folder for stops.csv, plan.csv, pose.tum and summary.txt"},
       {"--truth", &o.truth, "drive on GROUND_TRUTH in place of POSE (simulator)"}},
      [&](const gw::RobotConfig& config) { return gw::navigate::NavigateNode::Create(config, o); });
}

// gw-grid: floor map and obstacles from depth.
#include <opencv2/core.hpp>

#include "grid/process/grid_node.h"

int main(int argc, char** argv) {
  cv::setNumThreads(1);  // the other core is the front-end's
  gw::grid::GridOptions o;
  return gw::process::RunProgram(
      argc, argv,
      {"gw-grid",
       "Floor map and obstacles from depth: CAMERA, FRAME_POSE, MAP_UPDATE and DR in, GRID and "
       "OBSTACLES out."},
      {{"--map", &o.map,
        "folder of the map on disk (as of gw-backend): the floor map is kept there and continued"},
       {"--out", &o.out, "folder for map.yaml and map.pgm, written every 30 s and at the end"}},
      [&](const gw::RobotConfig& config) { return gw::grid::GridNode::Create(config, o); });
}

// gw-backend: the map.
#include "backend/process/backend_node.h"

int main(int argc, char** argv) {
  std::string map_directory;
  bool localize_only = false;
  return gw::process::RunProgram(
      argc, argv, {"gw-backend", "Mapping: KEYFRAME in, MAP_UPDATE out, the map on disk."},
      {{"--map", &map_directory,
        "folder of the map on disk: continued when it holds one; without it the map dies with the "
        "process"},
       {"--localize-only", &localize_only, "use the map of --map and never change it"}},
      [&](const gw::RobotConfig& config) {
        return gw::backend::BackendNode::Create(
            config, map_directory,
            localize_only ? gw::backend::MapUse::kFrozen : gw::backend::MapUse::kGrow);
      });
}

// gw-record: a log of everything on the bus that never fills the disk.
#include "tools/robot/record/recorder_node.h"

int main(int argc, char** argv) {
  std::string folder = ".";
  std::string max_gb = "20";
  return gw::process::RunProgram(
      argc, argv,
      {"gw-record",
       "Records every channel into files of limited size; keeps what surrounds a fault."},
      {{"--out", &folder, "folder of the log (default: here); evidence goes into its events/"},
       {"--max-gb", &max_gb, "disk that all of it may use (default 20)"}},
      [&](const gw::RobotConfig& config) {
        return gw::record::RecorderNode::Create(config, folder, max_gb);
      });
}

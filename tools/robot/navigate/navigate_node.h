// gw-navigate as a node: POSE, WHEEL, OBSTACLES and GRID in, BASE_COMMAND and NOTE out.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/config/robot_config.h"
#include "common/process/shell.h"
#include "tools/robot/navigate/bus_time.h"
#include "tools/robot/navigate/driver.h"
#include "tools/robot/navigate/run_record.h"

namespace gw::navigate {

struct NavigateOptions {
  bool explore = false;   // the floor that is not known yet; no map and no waypoints then
  std::string map;        // map.yaml of map_server
  std::string waypoints;  // lines `index x y theta`
  std::string path;       // indices to visit, one a line; empty: all in order
  int laps = 1;
  std::string start;   // "x,y,theta" on the map where W began; empty: at the first stop
  std::string record;  // folder for the run's record; empty: none
  bool truth = false;  // drive on GROUND_TRUTH in place of POSE
};

class NavigateNode : public process::Node {
 public:
  // Error kBadData or kNotFound for files, kInvalidArgument for options, each naming what is wrong.
  static Result<std::unique_ptr<process::Node>> Create(const RobotConfig& config,
                                                       const NavigateOptions& options);

  Result<Done> Start(process::Shell& shell) override;
  bool Step(process::Shell& shell) override;
  // Leaves the base with a command to stop.
  void Stop(process::Shell& shell) override;

 private:
  NavigateNode(std::unique_ptr<Driver> driver, const SE3& T_MW, bool truth)
      : driver_(std::move(driver)), T_MW_(T_MW), truth_(truth) {}

  static Result<std::unique_ptr<NavigateNode>> CreateTour(const RobotConfig& config,
                                                          const NavigateOptions& options);
  static Result<std::unique_ptr<NavigateNode>> CreateExplorer(const RobotConfig& config,
                                                              const NavigateOptions& options);

  void Take(const std::optional<RobotPose>& pose);
  void Command(Utime now, const floorplan::Speed& speed, process::Shell& shell);
  void Tell(Utime now, const Event& event, process::Shell& shell);
  void ReportHealth(process::Shell& shell);

  std::unique_ptr<Driver> driver_;
  std::vector<std::string> complaints_;  // of stops that cannot be visited
  SE3 T_MW_;
  bool truth_;
  std::optional<RunRecord> record_;
  BusTime time_;
  std::optional<RobotPose> pose_;
  std::optional<Utime> updated_;  // clock
  Utime recorded_;
  int64_t command_seq_ = 0;
  int64_t note_seq_ = 0;
};

}  // namespace gw::navigate

// What a tour leaves behind, for gw-nav-eval and people. All in the frame of the floor map, m and
// rad; utime in us.
//   stops.csv  utime,stop,waypoint,status,x_plan,y_plan,yaw_plan,x,y,yaw,sigma_m
//              a line for each stop: status reached or unreachable, where it should be, where the
//              robot believed to be
//              (waypoint -1: of exploration, a place to look from)
//   plan.csv   stop,x,y: the points of every planned way, in order
//   pose.tum   `t x y 0 0 0 qz qw`: the poses it drove on, 20 a second
//   summary.txt  what was done, in one line; only when it came to its end
#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include "common/core/result.h"
#include "tools/robot/navigate/driver.h"

namespace gw::navigate {

class RunRecord {
 public:
  // Makes the folder; overwrites. Error kIo.
  static Result<RunRecord> Create(const std::string& folder);

  // place, waypoint: of the stop.
  void AddStop(const Event& event, int waypoint, const floorplan::Waypoint& place);
  void AddLeg(int stop, const floorplan::Leg& leg);
  void AddPose(const RobotPose& pose);
  void SetSummary(const std::string& text);
  // Error kIo when something could not be written.
  Result<Done> Close();

 private:
  using File = std::unique_ptr<FILE, int (*)(FILE*)>;
  RunRecord(std::string folder, File stops, File plan, File poses)
      : folder_(std::move(folder)),
        stops_(std::move(stops)),
        plan_(std::move(plan)),
        poses_(std::move(poses)) {}

  std::string folder_;
  File stops_, plan_, poses_;
  bool summary_good_ = true;
};

}  // namespace gw::navigate

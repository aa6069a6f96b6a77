// How well a tour was driven, from the record of gw-navigate (tools/robot/navigate/run_record.h)
// and the ground truth in the frame of the same map. The measures are those of TaskSLAM-Bench (Du
// et al. 2024):
//   accuracy   of a stop: distance of where the robot truly stood to where it should stand
//   precision  of a waypoint visited at least twice: mean distance of its true stops to their mean;
//              needs no plan, so a map that is wrong but always the same costs nothing
//   est-RMSE   of the poses driven on against the truth, in the map, not aligned
//   nav-RMSE   of the true positions against the planned way to the stop that was next
// Headings likewise, in rad.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "tools/lab/eval/trajectory.h"
#include "tools/robot/floorplan/planner.h"

namespace gw::navigate {

struct StopRecord {
  Utime utime;
  int stop = 0;
  int waypoint = 0;
  bool reached = false;
  floorplan::Waypoint place;  // where it should stand
};

struct TourRecord {
  std::vector<StopRecord> stops;
  std::map<int, std::vector<floorplan::Leg>> legs;  // by the stop they lead to
  eval::Trajectory poses;
};

// From the folder that `gw-navigate --record` wrote. Error kNotFound, or kBadData with file and
// line.
Result<TourRecord> ReadTourRecord(const std::string& folder);

struct ClosedLoop {
  int stops = 0, reached = 0;
  double accuracy_m = 0, accuracy_rad = 0;    // mean over the stops reached
  int precision_waypoints = 0;                // 0: the next two mean nothing
  double precision_m = 0, precision_rad = 0;  // mean over these waypoints
  double est_rmse_m = 0, nav_rmse_m = 0;
};

// Error kBadData when poses and truth share no time.
Result<ClosedLoop> Evaluate(const TourRecord& record, const eval::Trajectory& truth);

}  // namespace gw::navigate

// How gw-navigate drives (section `navigate`).
#pragma once

#include "common/core/fields.h"

namespace gw {

struct NavigateConfig {
  double robot_radius_m = 0.1775;
  double clearance_m = 0.06;
  double max_speed_m_s = 0.5;
  double max_turn_deg_s = 60;
  double reach_m = 0.2;
  double reach_rad = 0.25;
  double pause_s = 1.0;
  int pose_timeout_ms = 150;
  double slow_sigma_m = 0.1;
  double stop_sigma_m = 0.4;
  double slow_sigma_deg = 3;
  double stop_sigma_deg = 12;
  double give_up_s = 30;
  double blind_speed_m_s = 0.15;

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Field("robot_radius_m", robot_radius_m,
            {.min = 0.01, .max = 2, .unit = "m", .text = "of the circle that holds the robot"});
    v.Field("clearance_m", clearance_m,
            {.min = 0,
             .max = 2,
             .unit = "m",
             .text = "planned ways keep this from the robot's circle to walls"});
    v.Field("max_speed_m_s", max_speed_m_s,
            {.min = 0.05, .max = 0.7, .unit = "m/s", .text = "fastest, with a good pose"});
    v.Field("max_turn_deg_s", max_turn_deg_s,
            {.min = 5, .max = 110, .unit = "deg/s", .text = "fastest turn"});
    v.Field(
        "reach_m", reach_m,
        {.min = 0.02, .max = 5, .unit = "m", .text = "a waypoint is reached within this distance"});
    v.Field("reach_rad", reach_rad,
            {.min = 0.02, .max = 3.15, .unit = "rad", .text = "and within this heading"});
    v.Field("pause_s", pause_s,
            {.min = 0.5, .max = 600, .unit = "s", .text = "standing still at each waypoint"});
    v.Field("pose_timeout_ms", pose_timeout_ms,
            {.min = 20,
             .max = 250,
             .unit = "ms",
             .text = "a POSE older than this is stale and stops the robot"});
    v.Field("slow_sigma_m", slow_sigma_m,
            {.min = 1e-3,
             .max = 10,
             .unit = "m",
             .text = "position uncertainty (1 sigma) above which it drives slower"});
    v.Field("stop_sigma_m", stop_sigma_m,
            {.min = 1e-3, .max = 10, .unit = "m", .text = "and at which it stops"});
    v.Field("slow_sigma_deg", slow_sigma_deg,
            {.min = 0.01,
             .max = 180,
             .unit = "deg",
             .text = "heading uncertainty (1 sigma) above which it drives slower"});
    v.Field("stop_sigma_deg", stop_sigma_deg,
            {.min = 0.01, .max = 180, .unit = "deg", .text = "and at which it stops"});
    v.Field(
        "give_up_s", give_up_s,
        {.min = 1,
         .max = 3600,
         .unit = "s",
         .text =
             "a waypoint that comes no nearer for this long, with a good pose, is unreachable"});
    v.Field("blind_speed_m_s", blind_speed_m_s,
            {.min = 0.02,
             .max = 0.7,
             .unit = "m/s",
             .text = "fastest over floor that gw-grid does not see, where it listens to gw-grid"});
  }
};

}  // namespace gw

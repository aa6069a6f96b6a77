// How gw-grid turns depth into a floor map and obstacles (section `grid`).
#pragma once

#include "common/core/fields.h"

namespace gw {

struct GridConfig {
  double rate_hz = 0;
  double cell_m = 0.05;
  double step_m = 0.05;
  double robot_height_m = 0.45;
  double tilt_deg = 1;
  double max_range_m = 4;
  double disparity_sigma_px = 0.2;
  double memory_s = 10;

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Field(
        "rate_hz", rate_hz,
        {.min = 0,
         .max = 60,
         .unit = "Hz",
         .text = "images a second that are turned into depth; those between are not looked at; 0: "
                 "10 of RGB-D, 5 of stereo, which takes half a core to match at 10"});
    v.Field("cell_m", cell_m,
            {.min = 0.02, .max = 0.25, .unit = "m", .text = "side of a cell of the grid"});
    v.Field("step_m", step_m,
            {.min = 0.01,
             .max = 0.3,
             .unit = "m",
             .text = "what is lower is floor, what is deeper is a hole; above what the robot can "
                     "climb and the noise of depth"});
    v.Field("robot_height_m", robot_height_m,
            {.min = 0.05,
             .max = 3,
             .unit = "m",
             .text = "what begins higher above the floor is no obstacle"});
    v.Field("tilt_deg", tilt_deg,
            {.min = 0,
             .max = 10,
             .unit = "deg",
             .text = "how far the camera may be tilted against the floor other than T_BC says; "
                     "raises step_m with the distance"});
    v.Field("max_range_m", max_range_m,
            {.min = 0.5, .max = 20, .unit = "m", .text = "nothing farther away is used"});
    v.Field("disparity_sigma_px", disparity_sigma_px,
            {.min = 0.01,
             .max = 5,
             .unit = "px",
             .text = "stereo only: standard deviation of a matched disparity, in pixels of the "
                     "camera; of RGB-D calibration.camera.disparity_sigma_px tells it"});
    v.Field("memory_s", memory_s,
            {.min = 0,
             .max = 600,
             .unit = "s",
             .text = "how long an obstacle that is out of view stays in OBSTACLES"});
  }
};

}  // namespace gw

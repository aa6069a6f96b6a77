// The table of study "real-wheels": what became of the pose where the odometry of a real robot was
// driven under a rendered camera.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/lab/study/experiment.h"
#include "tools/lab/study/fault_measures.h"

namespace gw::study {

struct RealWheelsRow {
  std::string name;
  double way_m = 0, seconds = 0;
  // RMSE of the positions, m, of poses as published; empty: not determined.
  std::optional<double> wheels_m, dr_m;
  FaultNumbers none, full;
  std::string said;  // what `full` said was wrong, by reason
};

// Of one run: `full` over the better of the wheels and vision alone, and over the wheels.
struct RealWheelsRatios {
  std::optional<double> to_best, to_wheels;
};
RealWheelsRatios RatiosOf(const RealWheelsRow& row);

// Bars: full <= 1.05 x the better of wheels and vision alone on each run, <= 0.5 x the wheels in
// the mean of the ratios; a pose for every image.
StudyFiles RenderRealWheels(const std::string& origin, const std::vector<RealWheelsRow>& rows);

}  // namespace gw::study

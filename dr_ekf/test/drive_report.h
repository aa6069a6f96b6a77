// What DR alone makes of a recorded drive, beside the wheels' own sum, in numbers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/config/dr_ekf_config.h"
#include "common/contract/dead_reckoning.h"
#include "dr_ekf/core/dr_filter.h"
#include "dr_ekf/test/recordings.h"

namespace gw::dr_ekf {

// RMSE in the plane after the best turn about z and shift; `estimate` interpolated to the times of
// `reference`, not across gaps of more than 4 s. -1: fewer than 10 common instants.
double PlanarApe(const std::vector<StampedPose>& reference,
                 const std::vector<StampedPose>& estimate);

// Signed way along the body's x, and the unwrapped turn, from the first pose to the last.
double WayOf(const std::vector<StampedPose>& poses);
double TurnOf(const std::vector<StampedPose>& poses);  // rad

struct DriveReport {
  std::vector<DrState> states;
  std::vector<StampedPose> poses;
  DrCounters counters;
  std::vector<DrEvent> events;
  std::vector<DrDiagnosis> found;

  double ape_dr = -1, ape_raw = -1;  // m; -1: no reference
  double way_dr = 0, way_raw = 0;    // m
  double turn_dr = 0, turn_raw = 0;  // rad
  double lowest = 0, highest = 0;    // m
  int slips = 0;                     // times the flag went up
};

DriveReport RunDrive(const RealDrive& drive, const DrEkfConfig& config = {});
void PrintReport(const std::string& name, const DriveReport& report);

}  // namespace gw::dr_ekf

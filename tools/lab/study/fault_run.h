// One run of the system over a log with a fault in it, and what the system said of the fault.
#pragma once

#include <map>
#include <string>

#include "tools/data/fault/fault_plan.h"
#include "tools/lab/slam/dr_only.h"
#include "tools/lab/study/experiment.h"

namespace gw::study {

// Whom the system accuses; kDr: wheels or IMU, or where the camera is mounted.
enum class Accused { kVision, kDr, kWheels, kImu };

// Something that the system names: a reason of FRAME_POSE, a diagnosis of the DR filter, or a begin
// of slip.
struct Finding {
  Utime first;        // of the log: when it was said first
  int64_t count = 0;  // images with the reason; diagnoses; begins of slip
  Accused accused = Accused::kVision;
  // HEALTH would name it: a diagnosis, or a reason for which the front-end was degraded for a
  // second of images (the period of HEALTH) in all.
  bool in_health = false;
};
using Findings = std::map<std::string, Finding>;  // by its name

struct FaultRun {
  measure::SlamRun run;
  Findings findings;
  std::string explanation;  // SlamSession::dr_fault(), length_fault(), view_fault()
};

// The log through the fault (an empty plan: none) and the system. seed: see run_log.h. Error: as of
// the log and the stages; kBadData when no image can be used.
Result<FaultRun> RunWithFault(Experiment* experiment, const RobotConfig& config,
                              const fault::FaultPlan& plan, int seed);

// Dead reckoning alone of the same log.
struct DeadReckoning {
  eval::Trajectory filter;  // T_OB of the DR filter, or of the log
  eval::Trajectory wheels;  // the wheels' own sum; empty without WHEEL
};
Result<DeadReckoning> ReckonWithFault(const Experiment& experiment, const RobotConfig& config,
                                      const fault::FaultPlan& plan);

}  // namespace gw::study

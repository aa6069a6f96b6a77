// The faults that a matrix tries on a log.
#pragma once

#include <string>
#include <vector>

#include "common/config/robot_config.h"
#include "tools/data/fault/fault_plan.h"
#include "tools/lab/study/fault_run.h"

namespace gw::study {

enum class FaultMatrix { kDr, kVision };

// A fault of the log (plan), or of the configuration (config differs from the robot's).
struct FaultCase {
  std::string name;
  std::string text;
  fault::FaultPlan plan;
  RobotConfig config;
  DurationUs begin;  // of the fault, since the begin of the log
  Accused guilty = Accused::kVision;
  // Brings poses of a run with this configuration to the robot's body: where the extrinsics are
  // wrong, vision alone tells where the camera is, and nothing of the body.
  SE3 T_BB;
};

// Those that make sense for the robot: faults of sensors that it has. Events that happen once, such
// as a jump, are put into the middle of the log, where the way is long. from: the others begin
// then, since the begin of the log; what is wrong in the configuration is so from the begin, or not
// tried.
std::vector<FaultCase> FaultCases(FaultMatrix matrix, const RobotConfig& robot,
                                  DurationUs log_length, DurationUs from = {});

// The chosen ones, in the order of the names (all when there are none). Error kInvalidArgument: a
// name that is not there.
Result<std::vector<FaultCase>> ChooseCases(const std::vector<FaultCase>& cases,
                                           const std::vector<std::string>& names);

}  // namespace gw::study

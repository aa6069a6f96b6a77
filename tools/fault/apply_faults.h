// Applies a FaultPlan to a log.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "tools/fault/fault_plan.h"

namespace gw::fault {

struct FaultSummary {
  int64_t events = 0, bytes = 0;  // written
  int64_t black_frames = 0, frozen_frames = 0, blurred_frames = 0, dropped_frames = 0;
  int64_t delayed = 0;
  int64_t slipped = 0;      // WHEEL and DR messages
  int64_t biased = 0;       // IMU messages
  int64_t teleported = 0;   // messages left out
  int64_t left_out = 0;     // messages of estimates, which would not fit the edited input
  int64_t undecodable = 0;  // passed on as they are
};

using Progress = std::function<void(int64_t bytes_done, int64_t bytes_total)>;

// Keeps the sensors, GROUND_TRUTH, BASE_COMMAND, notes, and channels that are not ours; estimates
// (FRAME_POSE, POSE, KEYFRAME, ...) are left out, because the stages make new ones. Messages that
// no edit touches keep their bytes. A note for each edit stands behind the notes at the begin. `to`
// appears only when it is complete. Error: kNotFound, kIo, kBadData (empty log), kInvalidArgument
// (same file).
Result<FaultSummary> ApplyFaults(const std::string& from, const FaultPlan& plan,
                                 const std::string& to, const Progress& progress);

}  // namespace gw::fault

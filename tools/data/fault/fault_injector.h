// Faults in a stream of log events: events in, edited events out, in order of their new times.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "common/process/event_log.h"
#include "common/wire/wire.h"
#include "tools/data/fault/fault_plan.h"

namespace gw::fault {

struct FaultSummary {
  int64_t events = 0, bytes = 0;  // given out; bytes of the log that was written
  int64_t black_frames = 0, frozen_frames = 0, blurred_frames = 0, dropped_frames = 0;
  int64_t delayed = 0;
  int64_t slipped = 0;      // WHEEL and DR messages
  int64_t biased = 0;       // IMU messages
  int64_t teleported = 0;   // messages left out
  int64_t left_out = 0;     // messages of estimates, which would not fit the edited input
  int64_t named = 0;        // messages that went through a named fault
  int64_t undecodable = 0;  // passed on as they are
};

// Keeps the sensors, GROUND_TRUTH, BASE_COMMAND, notes, and channels that are not ours; estimates
// (FRAME_POSE, POSE, KEYFRAME, ...) are left out, because the stages make new ones. Messages that
// no edit touches keep their bytes. A note for each edit stands behind the notes at the begin.
class FaultInjector {
 public:
  // Takes an event that goes out; its error ends the work.
  using Sink = std::function<Result<Done>(Utime received, std::string_view channel,
                                          const wire::Bytes& message)>;

  // Spans of the plan count from the first event.
  FaultInjector(FaultPlan plan, Sink sink);
  FaultInjector(FaultInjector&&) noexcept;
  ~FaultInjector();

  // Events in order of their times. What goes out may lag by one event, delayed messages by more.
  // Error: of the sink.
  Result<Done> Add(const process::LogEvent& event);
  // Gives out what still waits. Error: of the sink.
  Result<FaultSummary> Finish();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gw::fault

// A log through a SlamSession.
//
// The system is deterministic, so repeated runs need a source of variation. A seed shifts the
// start: seed N drops the first kImagesPerSeed * N images. The first keyframe, and with it all
// landmarks that the map begins with, the moments of all later keyframes and what local BA knows at
// which image come out differently, as they do between live runs; sensor data stays what was
// recorded. (Noise added to the pixels would be ours, not the camera's.) Seed 0 is the log as it
// is.
#pragma once

#include <functional>

#include "tools/data/log/log_clock.h"
#include "tools/data/log/span.h"
#include "tools/lab/slam/slam_session.h"

namespace gw::tools {

inline constexpr int kImagesPerSeed = 3;  // 0.1 s at 30 Hz

struct LogRunOptions {
  int seed = 0;  // >= 0
  Span span;     // images of this part only; dead reckoning knows the log from its begin
};

// Feeds the events of the log and finishes the session; also those of a log in which time goes back
// (logs that were joined, a clock that was set): returns where it does. after_event: for progress
// and timing. Error: kIo, when reading fails half-way.
Result<LogClock> RunLog(process::EventLogReader& log, const LogRunOptions& options,
                        SlamSession* session,
                        const std::function<void(const process::LogEvent&)>& after_event = nullptr);

}  // namespace gw::tools

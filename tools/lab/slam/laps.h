// The same log several times in one session, the map kept: the repeat-run protocol.
//
// Lap k gives the log's events with times moved by (k - 1) times its length, where the length is
// from the first image to the last and one mean image period more. What happens at the seam:
// SlamSession::BeginLap.
#pragma once

#include <string>
#include <vector>

#include "tools/lab/slam/run_log.h"

namespace gw::tools {

struct TimedKeyframe {
  Utime utime;  // of the log: without the lap's shift
  SE3 T_WC;
};

struct Lap {
  DurationUs shift;
  size_t frames_begin = 0, frames_end = 0;  // of session.frames()
  // The map when the lap ended.
  int64_t revision = 0;
  int64_t landmarks = 0;
  int64_t keyframes = 0;
  int64_t keyframes_inserted = 0;  // during this lap
  // Keyframes of this and earlier laps as they were then, by log time; where two laps made one from
  // the same image, the newer.
  std::vector<TimedKeyframe> poses;
};

// What is wrong with the file, in its last reading.
struct LogState {
  int64_t skipped_bytes = 0;
  bool truncated = false;
  std::vector<TimeStep> time_steps;  // where its time goes back or jumps ahead
};

struct LapsRun {
  std::vector<Lap> laps;
  LogState log;
};

// Reads the log once per lap. A log without images ends after the first. after_event: see RunLog;
// also gets the share of the whole work that is done.
// Errors: those of EventLogReader::Open and RunLog.
Result<LapsRun> RunLaps(
    const std::string& log_path, int laps, const LogRunOptions& options, SlamSession* session,
    const std::function<void(const process::LogEvent&, double done)>& after_event = nullptr);

}  // namespace gw::tools

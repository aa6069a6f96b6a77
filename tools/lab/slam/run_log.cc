#include "tools/lab/slam/run_log.h"

#include "common/wire/channels.h"

namespace gw::tools {

Result<LogClock> RunLog(process::EventLogReader& log, const LogRunOptions& options,
                        SlamSession* session,
                        const std::function<void(const process::LogEvent&)>& after_event) {
  int images_to_drop = kImagesPerSeed * options.seed;
  LogClock clock;
  while (const auto event = log.Next()) {
    const DurationUs since_begin = clock.Add(event->received);
    if (since_begin >= options.span.end) break;
    if (event->channel == wire::kCamera) {
      if (!options.span.Contains(since_begin)) continue;
      if (images_to_drop > 0) {
        --images_to_drop;
        continue;
      }
    }
    session->Process(*event);
    if (after_event) after_event(*event);
  }
  if (log.error()) return *log.error();
  session->Finish();
  return clock;
}

}  // namespace gw::tools

#include "tools/lab/slam/run_log.h"

#include <optional>

#include "lcmtypes/wire/channels.h"

namespace gw::tools {

Result<Done> RunLog(process::EventLogReader& log, const LogRunOptions& options,
                    SlamSession* session,
                    const std::function<void(const process::LogEvent&)>& after_event) {
  int images_to_drop = kImagesPerSeed * options.seed;
  std::optional<Utime> begin;
  while (const auto event = log.Next()) {
    if (!begin) begin = event->received;
    const DurationUs since_begin = event->received - *begin;
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
  return Done{};
}

}  // namespace gw::tools

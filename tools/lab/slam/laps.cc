#include "tools/lab/slam/laps.h"

#include <algorithm>
#include <map>

namespace gw::tools {
namespace {

// Time that the images from `begin` on take; from the earliest to the latest, should their times go
// back.
DurationUs LogLength(const std::vector<FramePose>& frames, size_t begin) {
  const size_t n = frames.size() - begin;
  const auto [first, last] =
      std::minmax_element(frames.begin() + static_cast<std::ptrdiff_t>(begin), frames.end(),
                          [](const FramePose& a, const FramePose& b) { return a.utime < b.utime; });
  const DurationUs span = last->utime - first->utime;
  return n < 2 ? span + Milliseconds(1000)
               : span + DurationUs{span.us / static_cast<int64_t>(n - 1)};
}

std::vector<TimedKeyframe> PosesByLogTime(const SlamSession& session,
                                          const std::vector<Lap>& laps) {
  std::map<Utime, SE3> by_time;
  const auto& keyframes = session.mapper().map().keyframes();
  for (auto it = keyframes.upper_bound(session.newest_before()); it != keyframes.end(); ++it) {
    const Keyframe& keyframe = it->second.frame;
    DurationUs shift;
    for (const Lap& lap : laps) {
      if (keyframe.utime >= session.frames()[lap.frames_begin].utime) shift = lap.shift;
    }
    by_time[keyframe.utime - shift] = keyframe.T_WC;
  }
  std::vector<TimedKeyframe> out;
  for (const auto& [utime, T_WC] : by_time) out.push_back({utime, T_WC});
  return out;
}

}  // namespace

Result<LapsRun> RunLaps(
    const std::string& log_path, int laps, const LogRunOptions& options, SlamSession* session,
    const std::function<void(const process::LogEvent&, double done)>& after_event) {
  LapsRun out;
  DurationUs length;
  for (int k = 0; k < laps; ++k) {
    auto log = process::EventLogReader::Open(log_path);
    if (!log) return log.error();
    Lap lap;
    lap.shift = {length.us * k};
    lap.frames_begin = session->frames().size();
    const int64_t inserted_before = session->mapper().counters().keyframes_inserted;
    if (k > 0) session->BeginLap(lap.shift);
    const auto clock = RunLog(*log, options, session, [&](const process::LogEvent& event) {
      if (!after_event) return;
      const double share = static_cast<double>(log->position()) /
                           static_cast<double>(std::max<int64_t>(log->size(), 1));
      after_event(event, (k + share) / laps);
    });
    if (!clock) return clock.error();
    out.log = {log->skipped_bytes(), log->truncated(), clock->steps()};
    lap.frames_end = session->frames().size();
    if (lap.frames_end == lap.frames_begin) break;
    if (k == 0) length = LogLength(session->frames(), 0);
    const backend::Mapper& mapper = session->mapper();
    lap.revision = mapper.map().revision();
    lap.landmarks = static_cast<int64_t>(mapper.map().num_landmarks());
    lap.keyframes = static_cast<int64_t>(mapper.map().keyframes().size());
    lap.keyframes_inserted = mapper.counters().keyframes_inserted - inserted_before;
    out.laps.push_back(std::move(lap));
    out.laps.back().poses = PosesByLogTime(*session, out.laps);
  }
  return out;
}

}  // namespace gw::tools

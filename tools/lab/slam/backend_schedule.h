// The back-end on the clock of the log: decides at which log time each of its results exists, so
// that gw-slam is deterministic and yet behaves like the live processes.
//
// A keyframe is inserted when it arrives, and loops are looked for; the update that takes it in
// leaves at once. One worker does local BA and the pose graphs of loops, which go first: each ends
// `latency` after it began; keyframes that arrive meanwhile wait for the next. A second worker does
// global BA after each closed loop and when it is due, in a time that follows from its size; a
// newer loop abandons it. Questions about a place are answered from the map at once, and the answer
// travels for `latency`.
#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "backend/core/mapper.h"

namespace gw::tools {

// How long the machine took for something that began at a time of the log.
struct MeasuredTime {
  Utime utime;
  int64_t us = 0;
};

class BackendSchedule {
 public:
  BackendSchedule(backend::Mapper mapper, DurationUs latency)
      : mapper_(std::move(mapper)), latency_(latency) {}

  // Times must not decrease over all calls. Each returns the updates that exist by then, in order.
  std::vector<MapUpdate> Insert(const Keyframe& keyframe, Utime now);
  std::vector<MapUpdate> AdvanceTo(Utime now);
  // The answer exists `latency` after the question.
  void Ask(const PlaceQuery& query, Utime now);
  std::vector<PlaceMatch> Answers(Utime now);
  // Lets everything that is still running end.
  std::vector<MapUpdate> Finish();

  // From now on notes how long each local BA takes to solve; now_us: a monotonic clock. It has no
  // influence.
  void MeasureLocalBa(std::function<int64_t()> now_us) { now_us_ = std::move(now_us); }

  const backend::Mapper& mapper() const { return mapper_; }
  const std::vector<MeasuredTime>& local_ba_times() const { return local_ba_times_; }

 private:
  void StartJob(Utime now);
  void StartGlobal(Utime now);
  std::optional<MapUpdate> EndJob();
  std::optional<MapUpdate> EndGlobal();

  backend::Mapper mapper_;
  DurationUs latency_;
  bool dirty_ = false;                         // keyframes came since the last local BA job was cut
  std::optional<backend::LoopGraphJob> loop_;  // waits for the worker

  // The first worker: one of the two, until ends_.
  std::optional<backend::LocalBaResult> local_;
  std::optional<backend::LoopGraphResult> graph_;
  Utime ends_;

  std::deque<std::pair<Utime, PlaceMatch>> answers_;

  // The second worker.
  std::optional<backend::LocalBaResult> global_;
  Utime global_ends_;

  std::function<int64_t()> now_us_;
  std::vector<MeasuredTime> local_ba_times_;
};

}  // namespace gw::tools

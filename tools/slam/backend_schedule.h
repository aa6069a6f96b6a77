// The back-end on the clock of the log: decides at which log time each of its results exists, so
// that gw-slam is deterministic and yet behaves like the live processes.
//
// A keyframe is inserted when it arrives; the update that takes it in leaves at once. Local BA
// starts when none is running and ends `latency` later; keyframes that arrive meanwhile wait for
// the next.
#pragma once

#include <optional>
#include <vector>

#include "backend/core/mapper.h"

namespace gw::tools {

class BackendSchedule {
 public:
  BackendSchedule(backend::Mapper mapper, DurationUs latency)
      : mapper_(std::move(mapper)), latency_(latency) {}

  // Times must not decrease over all calls. Each returns the updates that exist by then, in order.
  std::vector<MapUpdate> Insert(const Keyframe& keyframe, Utime now);
  std::vector<MapUpdate> AdvanceTo(Utime now);
  // Lets everything that is still running end.
  std::vector<MapUpdate> Finish();

  const backend::Mapper& mapper() const { return mapper_; }

 private:
  void StartJob(Utime now);

  backend::Mapper mapper_;
  DurationUs latency_;
  bool dirty_ = false;  // keyframes came since the last job was cut
  std::optional<backend::LocalBaResult> running_;
  Utime ends_;
};

}  // namespace gw::tools

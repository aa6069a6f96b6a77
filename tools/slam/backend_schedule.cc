#include "tools/slam/backend_schedule.h"

namespace gw::tools {

void BackendSchedule::StartJob(Utime now) {
  const auto job = mapper_.BuildJob();
  dirty_ = false;
  if (!job) return;
  running_ = backend::SolveLocalBa(*job);
  ends_ = now + latency_;
}

std::vector<MapUpdate> BackendSchedule::Insert(const Keyframe& keyframe, Utime now) {
  std::vector<MapUpdate> updates = AdvanceTo(now);
  backend::InsertResult inserted = mapper_.Insert(keyframe);
  if (inserted.update) updates.push_back(std::move(*inserted.update));
  dirty_ = true;
  if (!running_) StartJob(now);
  return updates;
}

std::vector<MapUpdate> BackendSchedule::AdvanceTo(Utime now) {
  std::vector<MapUpdate> updates;
  while (running_ && ends_ <= now) {
    if (auto update = mapper_.Apply(*running_)) updates.push_back(std::move(*update));
    running_.reset();
    if (dirty_) StartJob(ends_);
  }
  return updates;
}

std::vector<MapUpdate> BackendSchedule::Finish() {
  std::vector<MapUpdate> updates;
  while (running_) {
    for (MapUpdate& update : AdvanceTo(ends_)) updates.push_back(std::move(update));
  }
  return updates;
}

}  // namespace gw::tools

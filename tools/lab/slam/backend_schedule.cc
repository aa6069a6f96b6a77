#include "tools/lab/slam/backend_schedule.h"

#include "common/process/memory.h"

namespace gw::tools {
namespace {

// Log time that a global BA takes: measured 6 to 7 us of CPU time (300 keyframes, docs/results.md);
// live it shares its cores.
constexpr int64_t kGlobalUsPerObservation = 10;

}  // namespace

void BackendSchedule::StartJob(Utime now) {
  if (loop_) {
    graph_ = backend::SolveLoopGraph(*loop_);
    loop_.reset();
  } else if (dirty_) {
    dirty_ = false;
    if (const auto job = mapper_.BuildJob()) {
      const int64_t begin_us = now_us_ ? now_us_() : 0;
      local_ = backend::SolveLocalBa(*job);
      if (now_us_) local_ba_times_.push_back({now, now_us_() - begin_us});
    }
  }
  ends_ = now + latency_;
}

void BackendSchedule::StartGlobal(Utime now) {
  global_.reset();
  const auto job = mapper_.BuildGlobalJob();
  if (!job) return;
  global_ = backend::SolveLocalBa(*job);
  global_ends_ = now + DurationUs{kGlobalUsPerObservation * std::ssize(job->observations)};
}

std::optional<MapUpdate> BackendSchedule::EndJob() {
  std::optional<MapUpdate> update;
  if (graph_) {
    update = mapper_.Apply(*graph_);
    if (graph_->closed()) StartGlobal(ends_);
  } else {
    update = mapper_.Apply(*local_);
  }
  graph_.reset();
  local_.reset();
  StartJob(ends_);
  return update;
}

std::optional<MapUpdate> BackendSchedule::EndGlobal() {
  auto update = mapper_.ApplyGlobal(*global_);
  global_.reset();
  process::ReleaseFreeMemory();
  return update;
}

std::vector<MapUpdate> BackendSchedule::Insert(const Keyframe& keyframe, Utime now) {
  std::vector<MapUpdate> updates = AdvanceTo(now);
  backend::InsertResult inserted = mapper_.Insert(keyframe);
  if (inserted.update) {
    updates.push_back(std::move(*inserted.update));
    if (!loop_ && !graph_) loop_ = mapper_.CloseLoop();
    if (!global_ && mapper_.GlobalBaDue()) StartGlobal(now);
  }
  dirty_ = true;
  if (!local_ && !graph_) StartJob(now);
  return updates;
}

std::vector<MapUpdate> BackendSchedule::AdvanceTo(Utime now) {
  std::vector<MapUpdate> updates;
  const auto take = [&](std::optional<MapUpdate> update) {
    if (update) updates.push_back(std::move(*update));
  };
  while (true) {
    const bool job = (local_ || graph_) && ends_ <= now;
    const bool global = global_ && global_ends_ <= now;
    if (!job && !global) return updates;
    take(job && (!global || ends_ <= global_ends_) ? EndJob() : EndGlobal());
  }
}

void BackendSchedule::Ask(const PlaceQuery& query, Utime now) {
  answers_.emplace_back(now + latency_, mapper_.Locate(query));
}

std::vector<PlaceMatch> BackendSchedule::Answers(Utime now) {
  std::vector<PlaceMatch> out;
  while (!answers_.empty() && answers_.front().first <= now) {
    out.push_back(std::move(answers_.front().second));
    answers_.pop_front();
  }
  return out;
}

std::vector<MapUpdate> BackendSchedule::Finish() {
  std::vector<MapUpdate> updates;
  while (local_ || graph_ || global_) {
    const Utime next = local_ || graph_ ? ends_ : global_ends_;
    for (MapUpdate& update : AdvanceTo(next)) updates.push_back(std::move(update));
  }
  return updates;
}

}  // namespace gw::tools

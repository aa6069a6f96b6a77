#include "backend/process/backend_node.h"

#include <iterator>
#include <utility>

#include "common/camera/camera_model.h"
#include "common/process/memory.h"
#include "common/wire/channels.h"

namespace gw::backend {
namespace {

constexpr DurationUs kJournalRetry = Milliseconds(5000);

// Names of the counters in HEALTH.
constexpr std::pair<const char*, int64_t MapperCounters::*> kMapperCounters[] = {
    {"map.keyframes_inserted", &MapperCounters::keyframes_inserted},
    {"KEYFRAME.duplicate", &MapperCounters::keyframes_duplicate},
    {"KEYFRAME.rejected", &MapperCounters::keyframes_rejected},
    {"map.keyframes_culled", &MapperCounters::keyframes_culled},
    {"map.keyframes_withdrawn", &MapperCounters::keyframes_withdrawn},
    {"map.observations_accepted", &MapperCounters::observations_accepted},
    {"map.observations_unknown", &MapperCounters::observations_unknown},
    {"map.observations_repeated", &MapperCounters::observations_repeated},
    {"map.observations_found", &MapperCounters::observations_found},
    {"map.landmarks_invalid", &MapperCounters::landmarks_invalid},
    {"map.landmarks_created", &MapperCounters::landmarks_created},
    {"map.landmarks_triangulated", &MapperCounters::landmarks_triangulated},
    {"map.landmarks_merged", &MapperCounters::landmarks_merged},
    {"map.landmarks_culled", &MapperCounters::landmarks_culled},
    {"map.dr_rejected", &MapperCounters::dr_rejected},
    {"local_ba.applied", &MapperCounters::local_ba_applied},
    {"local_ba.stale", &MapperCounters::local_ba_stale},
    {"local_ba.failed", &MapperCounters::local_ba_failed},
    {"global_ba.applied", &MapperCounters::global_ba_applied},
    {"global_ba.stale", &MapperCounters::global_ba_stale},
    {"global_ba.failed", &MapperCounters::global_ba_failed},
    {"map.pieces_joined", &MapperCounters::pieces_joined},
};
static_assert(sizeof(MapperCounters) == sizeof(int64_t) * std::size(kMapperCounters));
constexpr std::pair<const char*, int64_t LoopCounters::*> kLoopCounters[] = {
    {"loops.candidates", &LoopCounters::candidates},
    {"loops.fits", &LoopCounters::fits},
    {"loops.inconsistent", &LoopCounters::inconsistent},
    {"loops.refused_by_dr", &LoopCounters::refused_by_dr},
    {"loops.closed", &LoopCounters::closed},
    {"loops.removed", &LoopCounters::removed},
};
static_assert(sizeof(LoopCounters) == sizeof(int64_t) * std::size(kLoopCounters));

void ReportCounters(const Mapper& mapper, process::HealthReporter& health) {
  for (const auto& [name, member] : kMapperCounters) {
    health.SetCounter(name, mapper.counters().*member);
  }
  for (const auto& [name, member] : kLoopCounters) {
    health.SetCounter(name, mapper.loop_counters().*member);
  }
}

}  // namespace

Result<std::unique_ptr<process::Node>> BackendNode::Create(const RobotConfig& config,
                                                           const std::string& map_directory,
                                                           MapUse use) {
  if (use == MapUse::kFrozen && map_directory.empty()) {
    return Error{ErrorCode::kInvalidArgument, "--localize-only needs --map DIR, the map to use"};
  }
  const auto geometry = MakeCameraGeometry(config.calibration);
  if (!geometry) return geometry.error();
  auto mapper = Mapper::Create(config.backend, config.frontend, geometry->rectified);
  if (!mapper) return mapper.error();
  return std::unique_ptr<process::Node>(
      new BackendNode(config, geometry->rectified, map_directory, use, std::move(*mapper)));
}

Result<Done> BackendNode::OpenMap(process::Shell& shell) {
  const MapSession session = MakeSession(shell.Now(), camera_, config_.frontend.orb);
  LoadedMap loaded;
  if (use_ == MapUse::kFrozen) {
    auto read = LoadMapFor(map_directory_, session.source);
    if (!read) return read.error();
    loaded = std::move(*read);
  } else {
    const JournalOptions options{.sync_interval = Milliseconds(config_.backend.journal_sync_ms)};
    auto journal = Journal::Open(map_directory_, options, session, loaded);
    if (!journal) return journal.error();
    journal_ = std::move(*journal);
  }
  auto mapper =
      Mapper::Create(config_.backend, config_.frontend, camera_, std::move(loaded.map), use_);
  if (!mapper) return mapper.error();
  mapper_ = std::move(*mapper);
  if (!loaded.damage.empty()) {
    shell.log().Write(shell.Now(), process::Severity::kWarning, "map.damaged",
                      {{"what", loaded.damage},
                       {"action", "nothing to do; the damaged files are kept as *.damaged"}});
  }
  for (const Keyframe& keyframe : loaded.pending) Insert(keyframe, true, shell);
  return Done{};
}

Result<Done> BackendNode::Start(process::Shell& shell) {
  const int64_t session = shell.Now().us;
  keyframes_.emplace(session);
  updates_.emplace(session);
  if (!map_directory_.empty()) {
    if (auto opened = OpenMap(shell); !opened) return opened;
  }
  shell.loop().Watch(solver_.fd());
  shell.loop().Watch(global_solver_.fd());

  Result<Done> ok = shell.ListenRaw(
      wire::kKeyframe, [this, &shell](auto bytes, Utime) { TakeKeyframes(bytes, shell); });
  if (!ok) return ok;
  ok = shell.Listen<wire::Ack>(wire::kMapUpdateAck,
                               [this](const wire::Ack& ack, Utime) { updates_->HandleAck(ack); });
  if (!ok) return ok;
  ok = shell.Listen<PlaceQuery>(wire::kPlaceQuery, [this, &shell](const PlaceQuery& query, Utime) {
    PlaceMatch match = mapper_.Locate(query);
    match.seq = ++place_match_seq_;
    shell.health().Count(match.found ? "PLACE_QUERY.found" : "PLACE_QUERY.not_found");
    shell.Publish(wire::kPlaceMatch, wire::Encode(match));
  });
  if (!ok) return ok;
  return shell.Listen<MapRequest>(wire::kMapRequest, [this](const MapRequest& request, Utime) {
    const auto guess = request.has_guess ? std::optional(request.T_WC_guess) : std::nullopt;
    updates_->Push(wire::Encode(mapper_.Snapshot(guess)));
  });
}

void BackendNode::TakeKeyframes(std::span<const uint8_t> message, process::Shell& shell) {
  for (const wire::Bytes& bytes : keyframes_->Accept(message)) {
    const auto keyframe = wire::Decode<Keyframe>(bytes);
    if (keyframe) {
      Insert(*keyframe, false, shell);
    } else {
      shell.CountUndecodable(wire::kKeyframe, keyframe.error());
    }
  }
  if (const auto ack = keyframes_->MakeAck(shell.Now())) {
    shell.Publish(wire::kKeyframeAck, wire::Encode(*ack));
  }
}

void BackendNode::Insert(const Keyframe& keyframe, bool journalled, process::Shell& shell) {
  const Utime begin = shell.Now();
  const InsertResult result = mapper_.Insert(keyframe);
  switch (result.status) {
    case InsertResult::Status::kDuplicate:
      return;
    case InsertResult::Status::kRejected:
      shell.log().Write(
          shell.Now(), process::Severity::kWarning, "keyframe.rejected",
          {{"why", result.reason}, {"action", "check that all processes use one robot YAML"}});
      return;
    case InsertResult::Status::kFrozen:
      shell.health().Count("KEYFRAME.frozen");
      return;
    case InsertResult::Status::kInserted:
      break;
  }
  if (!journalled) Journalize(keyframe, shell);
  Publish(*result.update, shell);
  dirty_ = true;
  if (!loop_ && !loop_runs_) loop_ = mapper_.CloseLoop();
  if (mapper_.GlobalBaDue()) global_wanted_ = true;
  shell.health().AddLatency(shell.Now() - begin);
}

void BackendNode::Publish(const MapUpdate& update, process::Shell& shell) {
  Journalize(update, shell);
  updates_->Push(wire::Encode(update));
}

template <typename Record>
void BackendNode::Journalize(const Record& record, process::Shell& shell) {
  if (!journal_ || journal_->failed()) return;
  const auto appended = journal_->Append(record, shell.Now());
  if (appended) return;
  shell.health().Count("journal.failed");
  shell.log().Write(
      shell.Now(), process::Severity::kError, "journal.failed",
      {{"what", appended.error().message},
       {"action", "free space; mapping goes on, the map on disk is the last complete one"}});
}

void BackendNode::CareForJournal(process::Shell& shell) {
  if (!journal_) return;
  const Utime now = shell.Now();
  if (const auto synced = journal_->SyncIfDue(now); !synced) shell.health().Count("journal.failed");
  if (!journal_->CheckpointDue()) return;
  if (last_journal_try_ && now - *last_journal_try_ < kJournalRetry) return;
  last_journal_try_ = now;
  if (const auto written = journal_->Checkpoint(mapper_.map()); !written) {
    shell.log().Write(
        now, process::Severity::kError, "journal.checkpoint_failed",
        {{"what", written.error().message}, {"action", "free space or check the disk"}});
  }
}

void BackendNode::TakeLoop(const LoopGraphResult& result, process::Shell& shell) {
  loop_runs_ = false;
  if (const auto update = mapper_.Apply(result)) Publish(*update, shell);
  if (!result.closed()) return;
  global_wanted_ = true;
  if (global_solver_.busy()) {
    global_solver_.Abandon();
    shell.health().Count("global_ba.abandoned");
  }
}

void BackendNode::TakeOutcomes(process::Shell& shell) {
  if (const auto outcome = solver_.Take()) {
    if (const auto* loop = std::get_if<LoopGraphResult>(&*outcome)) {
      TakeLoop(*loop, shell);
    } else if (const auto update = mapper_.Apply(std::get<LocalBaResult>(*outcome))) {
      Publish(*update, shell);
    }
  }
  if (const auto outcome = global_solver_.Take()) {
    if (const auto update = mapper_.ApplyGlobal(std::get<LocalBaResult>(*outcome))) {
      Publish(*update, shell);
    }
    process::ReleaseFreeMemory();
  }
}

void BackendNode::StartJobs() {
  if (!solver_.busy() && loop_) {
    solver_.Start(*std::exchange(loop_, std::nullopt));
    loop_runs_ = true;
  } else if (!solver_.busy() && dirty_) {
    dirty_ = false;
    if (auto job = mapper_.BuildJob()) solver_.Start(std::move(*job));
  }
  if (global_wanted_ && !global_solver_.busy()) {
    global_wanted_ = false;
    if (auto job = mapper_.BuildGlobalJob()) global_solver_.Start(std::move(*job));
  }
}

bool BackendNode::Step(process::Shell& shell) {
  TakeOutcomes(shell);
  StartJobs();
  for (const wire::Bytes* message : updates_->Due(shell.Now())) {
    shell.Publish(wire::kMapUpdate, *message);
  }
  CareForJournal(shell);
  ReportCounters(mapper_, shell.health());
  if (journal_ && journal_->failed()) {
    shell.health().SetState(HealthState::kDegraded, journal_->failure());
  } else {
    shell.health().SetState(HealthState::kOk);
  }
  return true;
}

void BackendNode::Stop(process::Shell& shell) {
  if (!journal_ || journal_->grown() == 0) return;
  // The next start then reads nothing but the map itself.
  if (const auto written = journal_->Checkpoint(mapper_.map()); !written) {
    shell.log().Write(shell.Now(), process::Severity::kError, "journal.checkpoint_failed",
                      {{"what", written.error().message},
                       {"action", "free space; what was recorded so far is safe"}});
  }
}

}  // namespace gw::backend

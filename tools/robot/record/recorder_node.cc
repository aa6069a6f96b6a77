#include "tools/robot/record/recorder_node.h"

#include <cstdlib>
#include <system_error>

#include "common/config/writer.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"

namespace gw::record {
namespace {

namespace fs = std::filesystem;

constexpr DurationUs kFlushEvery = Milliseconds(500);
constexpr DurationUs kFailedFor = Milliseconds(10'000);  // a lost message stays in HEALTH this long
constexpr double kEvidenceShare = 0.25;

}  // namespace

Result<std::unique_ptr<process::Node>> RecorderNode::Create(const RobotConfig& config,
                                                            const std::string& folder,
                                                            const std::string& max_gb) {
  char* end = nullptr;
  const double gb = std::strtod(max_gb.c_str(), &end);
  if (end == max_gb.c_str() || *end != '\0' || !(gb >= 0.1 && gb <= 1e5)) {
    return Error{ErrorCode::kInvalidArgument,
                 "--max-gb " + max_gb + ": must be a number between 0.1 and 100000"};
  }
  std::error_code error;
  const fs::path events = fs::path(folder) / "events";
  fs::create_directories(events, error);
  if (error) {
    return Error{ErrorCode::kIo, "--out " + folder + ": " + error.message() +
                                     "; name a folder that this user may write"};
  }
  const auto total = static_cast<int64_t>(gb * 1e9);
  const auto for_evidence = static_cast<int64_t>(kEvidenceShare * gb * 1e9);
  SegmentLimits limits;
  limits.total_bytes = total - for_evidence;
  auto log = SegmentLog::Open(folder, limits);
  if (!log) return log.error();
  return std::unique_ptr<process::Node>(new RecorderNode(
      *std::move(log), EvidenceKeeper(events, WriteRobotConfig(config), for_evidence)));
}

Result<Done> RecorderNode::Start(process::Shell& shell) {
  for (const wire::Channel& channel : wire::kChannels) {
    const std::string name(channel.name);
    const auto heard = shell.ListenRaw(
        name, [this, &shell, name](std::span<const uint8_t> message, Utime received) {
          Record(shell, name, message, received);
        });
    if (!heard) return heard.error();
  }
  shell.health().Count("recorded", 0);
  shell.health().Count("not_recorded", 0);
  return Done{};
}

void RecorderNode::Record(process::Shell& shell, const std::string& channel,
                          std::span<const uint8_t> message, Utime received) {
  const auto written = log_.Append(received, channel, message);
  shell.health().Count(written ? "recorded" : "not_recorded");
  if (!written) {
    last_failure_ = received;
    shell.log().Write(received, process::Severity::kError, "not_recorded",
                      {{"what", written.error().message}, {"action", "free disk space"}});
  }
  if (channel == wire::kHealth) WatchHealth(shell, message);
  if (channel == wire::kFramePose) {
    if (const auto pose = wire::Decode<FramePose>(message)) map_revision_ = pose->map_revision;
  }
}

void RecorderNode::WatchHealth(process::Shell& shell, std::span<const uint8_t> message) {
  const auto health = wire::Decode<Health>(message);
  if (!health) return;
  if (const auto fault = watch_.Observe(*health, shell.Now())) BeginEvidence(shell, *fault);
}

void RecorderNode::BeginEvidence(process::Shell& shell, const std::string& fault) {
  if (evidence_.Begin(fault, shell.Now())) shell.health().Count("evidence");
}

bool RecorderNode::Step(process::Shell& shell) {
  const Utime now = shell.Now();
  if (const auto fault = watch_.CheckSilence(now)) BeginEvidence(shell, *fault);
  const auto kept =
      evidence_.KeepIfDue(log_, "map revision " + std::to_string(map_revision_) + "\n", now);
  if (!kept) {
    last_failure_ = now;
    shell.log().Write(now, process::Severity::kError, "evidence",
                      {{"what", kept.error().message}, {"action", "free disk space"}});
  } else if (*kept) {
    shell.log().Write(now, process::Severity::kInfo, "evidence", {{"kept", (*kept)->string()}});
  }
  if (!last_flush_ || now - *last_flush_ >= kFlushEvery) {
    last_flush_ = now;
    if (const auto flushed = log_.Flush(); !flushed) last_failure_ = now;
  }
  if (last_failure_ && now - *last_failure_ < kFailedFor) {
    shell.health().SetState(HealthState::kFailed, "messages are not recorded: free disk space");
  } else {
    shell.health().SetState(HealthState::kOk);
  }
  return true;
}

void RecorderNode::Stop(process::Shell& shell) {
  if (const auto closed = log_.Close(); !closed) {
    shell.log().Write(shell.Now(), process::Severity::kError, "not_recorded",
                      {{"what", closed.error().message}, {"action", "free disk space"}});
  }
}

}  // namespace gw::record

#include "tools/lab/study/fault_run.h"

#include <utility>

#include "common/contract/tracking_names.h"
#include "common/wire/channels.h"
#include "frontend/core/tracking/health_cause.h"
#include "tools/data/fault/fault_injector.h"
#include "tools/lab/slam/dr_motion.h"

namespace gw::study {
namespace {

using Take = std::function<void(const process::LogEvent&)>;

// Gives out the events of the log with the fault in them. keep: which events of the log take part.
Result<Done> ReadWithFault(const std::string& path, const fault::FaultPlan& plan,
                           const std::function<bool(const process::LogEvent&)>& keep,
                           const Take& take) {
  auto log = process::EventLogReader::Open(path);
  if (!log) return log.error();
  fault::FaultInjector injector(
      plan,
      [&](Utime received, std::string_view channel, const wire::Bytes& message) -> Result<Done> {
        take({0, received, channel, message});
        return Done{};
      });
  while (const auto event = log->Next()) {
    if (!keep(*event)) continue;
    const auto added = injector.Add(*event);
    if (!added) return added.error();
  }
  if (log->error()) return *log->error();
  const auto finished = injector.Finish();
  if (!finished) return finished.error();
  return Done{};
}

Finding& Note(const std::string& name, Utime utime, Accused accused, Findings* findings) {
  Finding& finding = findings->try_emplace(name, Finding{utime, 0, accused}).first->second;
  ++finding.count;
  return finding;
}

Accused AccusedBy(dr_ekf::DrDiagnosis diagnosis) {
  using enum dr_ekf::DrDiagnosis;
  switch (diagnosis) {
    case kTimeWentBack:
    case kTimeJumpedAhead:
    case kParted:
      return Accused::kDr;
    case kHeadingStuck:
    case kWheelTurnStuck:
    case kTrackIsOther:
    case kWheelsTurnBackwards:
    case kWheelsNotNumbers:
    case kWheelsTwice:
    case kWheelsJumped:
    case kWheelsTooFast:
    case kWheelsStand:
    case kWheelsContradicted:
      return Accused::kWheels;
    case kImuOnAnotherClock:
    case kImuStampsRepeat:
    case kAccelInG:
    case kAccelWithoutGravity:
    case kAccelInUnknownUnit:
    case kAccelUnfit:
    case kGyroInDegrees:
    case kGyroFrozen:
    case kGyroBiasLarge:
    case kImuNotNumbers:
      return Accused::kImu;
  }
  return Accused::kDr;
}

Accused AccusedBy(TrackingReason reason) {
  return reason == TrackingReason::kDrContradictsVision ? Accused::kDr : Accused::kVision;
}

Accused SenderOf(std::string_view channel) {
  if (channel == wire::kImu) return Accused::kImu;
  return channel == wire::kCamera ? Accused::kVision : Accused::kWheels;
}

void NoteReasons(const std::vector<FramePose>& frames, double rate_hz, Findings* findings) {
  std::map<std::string, int64_t> degraded;  // images
  for (const FramePose& f : frames) {
    if (f.reason == TrackingReason::kNone) continue;
    const std::string name = ReasonName(f.reason);
    Finding& finding = Note(name, f.utime, AccusedBy(f.reason), findings);
    degraded[name] += !frontend::HealthCause(f, {}, {}, {}).empty();
    finding.in_health = static_cast<double>(degraded[name]) >= rate_hz;
  }
}

// Times must increase: a filter that began anew says some instants twice.
void Append(Utime utime, const SE3& T, eval::Trajectory* trajectory) {
  if (trajectory->empty() || trajectory->back().utime < utime) trajectory->push_back({utime, T});
}

}  // namespace

Result<FaultRun> RunWithFault(Experiment* experiment, const RobotConfig& config,
                              const fault::FaultPlan& plan, int seed) {
  auto session = tools::SlamSession::Create(config);
  if (!session) return session.error();
  FaultRun out;
  Utime now;
  session->WatchDr([&](const dr_ekf::DrFilter::Output& output) {
    for (const auto diagnosis : output.found) {
      Note(std::string(dr_ekf::Name(diagnosis)), now, AccusedBy(diagnosis), &out.findings)
          .in_health = true;
    }
    for (const auto event : output.events) {
      if (event == dr_ekf::DrEvent::kSlipBegin) Note("slip", now, Accused::kWheels, &out.findings);
    }
  });
  int images_to_drop = tools::kImagesPerSeed * seed;
  const auto done = ReadWithFault(
      experiment->path, plan,
      [&](const process::LogEvent& event) {
        return event.channel != wire::kCamera || images_to_drop-- <= 0;
      },
      [&](const process::LogEvent& event) {
        now = event.received;
        const int64_t undecodable = session->counters().undecodable;
        session->Process(event);
        if (session->counters().undecodable > undecodable) {
          Note("undecodable", now, SenderOf(event.channel), &out.findings).in_health = true;
        }
        if (event.channel != wire::kCamera) return;
        const auto note = [&](const char* name, Accused accused, const std::string& words) {
          if (!words.empty()) Note(name, now, accused, &out.findings).in_health = true;
        };
        note("constant", Accused::kDr, session->dr_fault());
        note("camera_scale", Accused::kVision, session->length_fault());
        note("view", Accused::kVision, session->view_fault());
      });
  if (!done) return done.error();
  session->Finish();
  if (session->frames().empty()) {
    return Error{ErrorCode::kBadData,
                 experiment->path + ": no image that can be used; see gw-log info"};
  }
  experiment->dr_synthetic |= session->dr_synthetic();
  out.run = measure::RunOf(*session);
  out.explanation = session->dr_fault() + session->length_fault() + session->view_fault();
  NoteReasons(out.run.frames, config.calibration.camera.rate_hz, &out.findings);
  return out;
}

Result<DeadReckoning> ReckonWithFault(const Experiment& experiment, const RobotConfig& config,
                                      const fault::FaultPlan& plan) {
  auto runner = tools::DrOnlyRunner::Create(config);
  if (!runner) return runner.error();
  const auto done = ReadWithFault(
      experiment.path, plan,
      [](const process::LogEvent& event) { return event.channel != wire::kCamera; },
      [&](const process::LogEvent& event) { runner->Add(event); });
  if (!done) return done.error();
  const tools::DrOnlyRun run = runner->Take();
  DeadReckoning out;
  for (const tools::DrPose& pose : run.poses) Append(pose.utime, pose.T_OB, &out.filter);
  if (run.wheels.empty()) return out;
  const auto offset = DurationFromSeconds(config.calibration.wheel.time_offset_s);
  for (const auto& [utime, T_OB] : tools::SumWheels(run.wheels, offset).poses) {
    Append(utime, T_OB, &out.wheels);
  }
  return out;
}

}  // namespace gw::study

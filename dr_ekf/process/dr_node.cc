#include "dr_ekf/process/dr_node.h"

#include <numbers>
#include <string>
#include <utility>

#include "common/wire/channels.h"

namespace gw::dr_ekf {
namespace {

// DR is called silent when no state has come for this long while the process runs.
constexpr DurationUs kSilence = Milliseconds(500);

}  // namespace

Result<std::unique_ptr<process::Node>> DrNode::Create(const RobotConfig& config) {
  std::optional<DrFilter> filter;
  const bool has_sensors = config.calibration.imu.present || config.calibration.wheel.present;
  if (config.dr_ekf.source == DrSource::kSensors && has_sensors) {
    auto created = DrFilter::Create(config.dr_ekf, config.calibration);
    if (!created) return created.error();
    filter = std::move(*created);
  }
  const GlideRates rates{config.dr_ekf.pose_correction_m_s,
                         config.dr_ekf.pose_correction_deg_s * std::numbers::pi / 180};
  return std::unique_ptr<process::Node>(new DrNode(std::move(filter), rates));
}

Result<Done> DrNode::Start(process::Shell& shell) {
  // Seconds of the clock: a restarted process never continues the count of the one before.
  first_reset_counter_ = static_cast<uint32_t>(shell.Now().us / 1'000'000);
  Result<Done> ok = Done{};
  if (filter_) {
    ok = shell.Listen<ImuSample>(wire::kImu, [this, &shell](const ImuSample& sample, Utime) {
      Take(filter_->Push(sample), shell);
    });
    if (!ok) return ok;
    ok = shell.Listen<WheelSample>(wire::kWheel, [this, &shell](const WheelSample& sample, Utime) {
      Take(filter_->Push(sample), shell);
    });
  } else {
    ok = shell.Listen<DrState>(
        wire::kDr, [this, &shell](const DrState& state, Utime) { PublishPose(state, shell); });
  }
  if (!ok) return ok;
  return shell.Listen<FramePose>(wire::kFramePose, [this, &shell](const FramePose& pose, Utime) {
    if (filter_) Take(filter_->Push(pose), shell);
    if (composer_.Push(pose) == LatchResult::kNoDeadReckoning) {
      shell.health().Count("frame_pose.without_dr");
    }
  });
}

void DrNode::Take(const DrFilter::Output& output, process::Shell& shell) {
  for (DrState state : output.states) {
    state.reset_counter += first_reset_counter_;
    shell.Publish(wire::kDr, wire::Encode(state));
    PublishPose(state, shell);
  }
  const auto count = [&](const char* name, int64_t before, int64_t now) {
    if (now > before) shell.health().Count(name, now - before);
  };
  const DrCounters& now = output.counters;
  count("dr.rejected_invalid", counters_.rejected_invalid, now.rejected_invalid);
  count("dr.rejected_late", counters_.rejected_late, now.rejected_late);
  count("dr.rejected_non_monotonic", counters_.rejected_non_monotonic, now.rejected_non_monotonic);
  count("dr.rejected_future", counters_.rejected_future, now.rejected_future);
  count("dr.rejected_absurd", counters_.rejected_absurd, now.rejected_absurd);
  count("dr.resets", counters_.resets, now.resets);
  count("dr.parted", counters_.step.parted, now.step.parted);
  for (const DrDiagnosis diagnosis : output.found) {
    shell.health().Count("dr.found." + std::string(Name(diagnosis)));
    found_ = Text(diagnosis);
  }
  counters_ = now;
}

void DrNode::PublishPose(const DrState& state, process::Shell& shell) {
  const auto composed = composer_.Push(state);
  if (!composed) {
    shell.health().Count("dr.not_newer");
    return;
  }
  last_state_ = shell.Now();
  Pose pose = glide_.Push(*composed, state.stationary);
  if (pose.reset_counter != pose_resets_) shell.health().Count("pose.snapped");
  pose_resets_ = pose.reset_counter;
  pose.reset_counter += first_reset_counter_;
  shell.Publish(wire::kPose, wire::Encode(pose));
}

bool DrNode::Step(process::Shell& shell) {
  if (!last_state_) {
    shell.health().SetState(HealthState::kStarting,
                            "no IMU, wheel or DR message yet: check the drivers");
  } else if (shell.Now() - *last_state_ > kSilence) {
    shell.health().SetState(HealthState::kDegraded, "dead reckoning is silent: check IMU and base");
  } else {
    shell.health().SetState(HealthState::kOk, found_);
  }
  return true;
}

}  // namespace gw::dr_ekf

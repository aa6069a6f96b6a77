#include "drivers/kobuki/device/kobuki_node.h"

#include <utility>

#include "common/config/writer.h"
#include "common/core/version.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"

namespace gw::kobuki {
namespace {

using process::Severity;

const char* Name(LinkState state) {
  switch (state) {
    case LinkState::kAbsent:
      return "absent";
    case LinkState::kConnecting:
      return "connecting";
    case LinkState::kSilent:
      return "silent";
    case LinkState::kGarbage:
      return "garbage";
    case LinkState::kTalking:
      return "talking";
  }
  return "";
}

}  // namespace

KobukiNode::KobukiNode(const RobotConfig& config, process::Bus* bus, Now now, process::LogLine log)
    : config_(config),
      bus_(bus),
      now_(std::move(now)),
      log_(std::move(log)),
      health_("gw-kobuki", gw::Version(), ConfigHash(config)),
      driver_(config.drivers.kobuki, config.calibration.wheel) {}

KobukiNode::~KobukiNode() {
  Shutdown();
}

Result<Done> KobukiNode::Start() {
  return bus_->Subscribe(wire::kBaseCommand, [this](std::span<const uint8_t> message, Utime) {
    const auto command = wire::Decode<BaseCommand>(message);
    if (!command) return health_.Count("kobuki.commands_undecodable");
    driver_.Command(*command, now_());
  });
}

void KobukiNode::OpenPort() {
  const Utime now = now_();
  auto path = FindPort(config_.drivers.kobuki.device);
  auto port = path ? SerialPort::Open(*path) : Result<SerialPort>(path.error());
  if (!port) {
    open_error_ = port.error().message;
    link_.OpenFailed(now);
    log_.Write(now, Severity::kWarning, "kobuki.absent", {{"action", open_error_}});
    return;
  }
  open_error_.clear();
  port_path_ = port->path();
  port_.emplace(std::move(*port));
  link_.Opened(now);
  driver_.PortOpened(now);
  log_.Write(now, Severity::kInfo, "kobuki.opened",
             {{"port", port_path_}, {"low_latency", port_->low_latency() ? "yes" : "no"}});
}

// A device that is gone is closed at once, so that it comes back under its old name.
void KobukiNode::ClosePort() {
  port_.reset();
  link_.Closed(now_());
}

void KobukiNode::ReadPort() {
  if (!port_) return;
  auto bytes = port_->Read();
  const Utime arrival = now_();
  if (!bytes) {
    open_error_ = bytes.error().message;
    log_.Write(arrival, Severity::kWarning, "kobuki.gone", {{"action", open_error_}});
    return ClosePort();
  }
  if (bytes->empty()) return;
  link_.Bytes(arrival);
  const int64_t frames = driver_.frame_counters().frames;
  Publish(driver_.Receive(*bytes, arrival));
  if (driver_.frame_counters().frames > frames) link_.Frame(arrival);
  health_.AddLatency(now_() - arrival);
}

void KobukiNode::Send(const std::vector<uint8_t>& bytes) {
  if (bytes.empty() || !port_) return;
  const auto sent = port_->Write(bytes);
  if (!sent) {
    open_error_ = sent.error().message;
    log_.Write(now_(), Severity::kWarning, "kobuki.gone", {{"action", open_error_}});
    ClosePort();
  } else if (!*sent) {
    health_.Count("kobuki.write_stalls");
  }
}

void KobukiNode::Tick() {
  const Utime now = now_();
  if (link_.ShouldReopen(now)) ClosePort();
  if (link_.ShouldOpen(now)) OpenPort();
  Send(driver_.Tick(now));
  const LinkState state = link_.state(now);
  if (state != logged_state_) {
    logged_state_ = state;
    if (state == LinkState::kTalking) {
      log_.Write(now, Severity::kInfo, "kobuki.talking", {{"port", port_path_}});
    } else if (state == LinkState::kSilent || state == LinkState::kGarbage) {
      log_.Write(now, Severity::kWarning, std::string("kobuki.") + Name(state),
                 {{"action", LinkMessage()}});
    }
  }
  PublishHealth();
}

std::string KobukiNode::LinkMessage() const {
  switch (link_state()) {
    case LinkState::kAbsent:
      return open_error_.empty() ? "the port is not open yet" : open_error_;
    case LinkState::kConnecting:
      return port_path_ + ": waiting for the base";
    case LinkState::kSilent:
      return port_path_ + ": the port is there but the base is silent: switch the base on";
    case LinkState::kGarbage:
      return port_path_ +
             ": what comes is no Kobuki feedback: another device (correct drivers.kobuki.device) "
             "or a bad cable";
    case LinkState::kTalking:
      return "";
  }
  return "";
}

void KobukiNode::Publish(const Driver::Samples& samples) {
  if (bus_ == nullptr) return;
  for (const WheelSample& sample : samples.wheel) Publish(wire::kWheel, wire::Encode(sample));
  if (!config_.drivers.kobuki.publish_imu) return;
  for (const ImuSample& sample : samples.imu) Publish(wire::kImu, wire::Encode(sample));
}

void KobukiNode::Publish(const char* channel, const std::vector<uint8_t>& message) {
  if (!bus_->Publish(channel, message)) health_.Count("kobuki.publish_failed");
}

void KobukiNode::UpdateHealth() {
  const Utime now = now_();
  switch (link_.state(now)) {
    case LinkState::kAbsent:
    case LinkState::kGarbage:
      health_.SetState(HealthState::kFailed, LinkMessage());
      break;
    case LinkState::kConnecting:
      health_.SetState(HealthState::kStarting, LinkMessage());
      break;
    case LinkState::kSilent:
      health_.SetState(HealthState::kDegraded, LinkMessage());
      break;
    case LinkState::kTalking: {
      const Condition condition = driver_.GetCondition(now);
      health_.SetState(condition.state, condition.message);
    }
  }
  for (const auto& [name, value] : driver_.Counters()) health_.SetCounter(name, value);
  health_.SetCounter("kobuki.port_opens", link_.opens());
}

void KobukiNode::PublishHealth() {
  if (bus_ == nullptr) return;
  UpdateHealth();
  if (const auto health = health_.ReportIfDue(now_()))
    Publish(wire::kHealth, wire::Encode(*health));
}

void KobukiNode::Shutdown() {
  if (!port_) return;
  // A device that never spoke as a Kobuki is sent nothing. The stop is sent more than once, because
  // a frame may be hit by noise and nobody answers.
  if (driver_.frame_counters().frames > 0) {
    for (int i = 0; i < 3 && port_; ++i) Send(Driver::StopBytes());
    if (port_) port_->Drain(200);
  }
  port_.reset();
}

}  // namespace gw::kobuki

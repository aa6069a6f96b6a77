#include "drivers/camera/device/camera_node.h"

#include <algorithm>
#include <utility>

#include "common/config/writer.h"
#include "common/core/version.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"

namespace gw::camera {
namespace {

using process::Severity;

// The time between two looks for a camera that is not there.
constexpr DurationUs kRetry = Milliseconds(500);
// Motion sensors need a second after the camera was plugged in, so that they are tried again at
// this interval.
constexpr DurationUs kMotionRetry = Milliseconds(2000);
constexpr DurationUs kDeviceErrorPeriod = Milliseconds(1000);
constexpr double kManyMissing = 0.05;

FrameMaker::Options MakerOptions(const RobotConfig& config, uint32_t fourcc) {
  const CameraConfig& camera = config.drivers.camera;
  return {.fourcc = fourcc,
          .side_by_side = camera.source == CameraSource::kUvcSideBySide,
          .width = config.calibration.camera.width,
          .height = config.calibration.camera.height,
          .emitter = camera.emitter,
          .transport_delay = DurationFromSeconds(1e-3 * camera.transport_delay_ms)};
}

StreamCounters Sum(const StreamCounters& a, const StreamCounters& b) {
  return {.images = a.images + b.images,
          .lost = a.lost + b.lost,
          .bad = a.bad + b.bad,
          .depth_lost = a.depth_lost + b.depth_lost,
          .depth_bad = a.depth_bad + b.depth_bad,
          .metadata_bad = a.metadata_bad + b.metadata_bad,
          .without_metadata = a.without_metadata + b.without_metadata,
          .unpaired = a.unpaired + b.unpaired};
}

std::string Join(const std::vector<std::string>& parts) {
  std::string out;
  for (const std::string& part : parts) out += (out.empty() ? "" : "; ") + part;
  return out;
}

}  // namespace

CameraNode::CameraNode(const RobotConfig& config, process::Bus* bus, System system,
                       process::LogLine log)
    : config_(config),
      bus_(bus),
      system_(std::move(system)),
      log_(std::move(log)),
      health_("gw-camera", gw::Version(), ConfigHash(config)),
      motion_(config, system_.monotonic_offset) {}

std::vector<int> CameraNode::fds() const {
  std::vector<int> out = motion_.fds();
  if (camera_) {
    const std::vector<int> video = camera_->fds();
    out.insert(out.end(), video.begin(), video.end());
  }
  return out;
}

void CameraNode::OpenCamera() {
  const Utime now = system_.now();
  retry_ = now + kRetry;
  const CameraConfig& config = config_.drivers.camera;
  auto found = FindCamera(config.source, config.device, system_.roots);
  auto camera = found ? Camera::Open(system_.calls, *found, config, config_.calibration.camera)
                      : Result<std::unique_ptr<Camera>>(found.error());
  if (!camera) {
    absent_ = camera.error();
    log_.Write(now, Severity::kWarning, "camera.absent", {{"action", absent_->message}});
    return;
  }
  found_ = *found;
  recovery_.Started(now);
  if (const auto started = (*camera)->Start(); !started) {
    absent_ = started.error();
    if (started.error().code == ErrorCode::kNotFound) {
      recovery_.Gone();
    } else {
      recovery_.Failed();
      waiting_for_remedy_ = true;
    }
    log_.Write(now, Severity::kWarning, "camera.start_failed", {{"action", absent_->message}});
    return;
  }
  camera_ = std::move(*camera);
  absent_.reset();
  ++opens_;
  if (maker_) {
    maker_->Restart(camera_->image_fourcc());
  } else {
    maker_.emplace(MakerOptions(config_, camera_->image_fourcc()));
  }
  if (config.exposure == ExposureMode::kCapped) {
    exposure_.emplace(ExposureLimits{.max_exposure_us = static_cast<uint32_t>(config.exposure_us)});
    if (!camera_->SetExposure(exposure_->setting())) exposure_.reset();
  }
  log_.Write(now, Severity::kInfo, "camera.opened",
             {{"serial", found_.serial}, {"streams", camera_->text()}});
}

// A device that is gone is closed at once, so that it comes back under its old name.
void CameraNode::CloseCamera(const std::string& why) {
  closed_ = Sum(closed_, camera_->counters());
  camera_.reset();
  absent_ = Error{ErrorCode::kIo, why};
  log_.Write(system_.now(), Severity::kWarning, "camera.closed", {{"why", why}});
}

void CameraNode::OpenMotion() {
  const Utime now = system_.now();
  motion_retry_ = now + kMotionRetry;
  const FirmwareVersion firmware = camera_->version()->firmware;
  // The sensors may have come later than the camera.
  const auto found = FindCamera(config_.drivers.camera.source, found_.serial, system_.roots);
  const auto opened =
      found ? motion_.Open(*found, firmware, system_.roots, now) : Result<Done>(found.error());
  motion_error_ = opened ? "" : opened.error().message;
  if (!opened) log_.Write(now, Severity::kWarning, "imu.absent", {{"action", motion_error_}});
}

void CameraNode::CloseMotion(const std::string& why) {
  motion_.Close();
  motion_error_ = why;
  motion_retry_ = system_.now() + kMotionRetry;
}

void CameraNode::Recover(Remedy remedy) {
  if (remedy == Remedy::kNone) return;
  waiting_for_remedy_ = false;
  const Utime now = system_.now();
  retry_ = now;
  switch (remedy) {
    case Remedy::kNone:
      return;
    case Remedy::kRestartStream:
      if (camera_) CloseCamera("the stream stopped; restarting it");
      return;
    case Remedy::kResetUsb: {
      if (camera_) CloseCamera("the stream stopped; resetting the camera");
      motion_.Close();
      const auto reset = system_.reset_usb(found_.bus, found_.address);
      log_.Write(now, Severity::kWarning, "camera.usb_reset",
                 {{"result", reset ? "ok" : reset.error().message}});
      return;
    }
    case Remedy::kGiveUp:
      gave_up_ =
          "the camera is there but delivers no images, and neither restarting the stream nor "
          "resetting it helps (" +
          (absent_ ? absent_->message : "no error") + "): unplug it, use another port or cable";
      if (camera_) CloseCamera(*gave_up_);
      health_.SetState(HealthState::kFailed, *gave_up_);
      if (bus_ != nullptr) {
        if (const auto health = health_.ReportIfDue(now + Milliseconds(1000))) {
          Publish(wire::kHealth, wire::Encode(*health));
        }
      }
      log_.Write(now, Severity::kError, "camera.gave_up", {{"action", *gave_up_}});
      return;
  }
}

void CameraNode::Tick() {
  const Utime now = system_.now();
  if (gave_up_) return;
  Recover(recovery_.Next(now));
  if (gave_up_) return;
  if (!camera_ && !waiting_for_remedy_ && (!retry_ || now >= *retry_)) OpenCamera();
  if (motion_.silent(now)) {
    CloseMotion("the motion sensors are silent: unplug the camera and plug it in again");
  }
  const bool motion_due = !motion_retry_ || now >= *motion_retry_;
  if (camera_ && motion_.wanted() && !motion_.open() && motion_due) OpenMotion();
  if (camera_ && config_.drivers.camera.source == CameraSource::kRealsense &&
      (!device_error_asked_ || now - *device_error_asked_ >= kDeviceErrorPeriod)) {
    device_error_asked_ = now;
    PollDeviceError();
  }
  if (bus_ == nullptr) return;
  UpdateHealth();
  if (const auto health = health_.ReportIfDue(now)) Publish(wire::kHealth, wire::Encode(*health));
}

void CameraNode::PollDeviceError() {
  const auto code = camera_->ReadDeviceError();
  device_error_ = code ? DeviceErrorText(*code) : "";
}

void CameraNode::Read(int fd) {
  const Utime now = system_.now();
  const std::vector<int> motion = motion_.fds();
  if (std::find(motion.begin(), motion.end(), fd) != motion.end()) {
    const auto samples = motion_.Read(fd, now);
    if (!samples) return CloseMotion(samples.error().message);
    for (const ImuSample& sample : *samples) Publish(wire::kImu, wire::Encode(sample));
    return;
  }
  if (!camera_) return;
  std::vector<CapturedFrame> frames;
  const StreamState state = camera_->Read(fd, &frames);
  for (CapturedFrame& frame : frames) Deliver(std::move(frame), now);
  if (state == StreamState::kFine) return;
  if (state == StreamState::kBroken) {
    recovery_.Failed();
    waiting_for_remedy_ = true;
    CloseCamera("the stream broke off with an error of the device");
    return;
  }
  recovery_.Gone();
  motion_.Close();
  CloseCamera("the camera was unplugged, or lost its power: plug it in again");
  retry_ = now + kRetry;
}

void CameraNode::Deliver(CapturedFrame frame, Utime now) {
  recovery_.Frame(now);
  const StreamCounters& stream = camera_->counters();
  const int64_t missing = stream.lost + stream.bad;
  for (; missing_seen_ < missing && missing - missing_seen_ <= 300; ++missing_seen_) {
    missing_.Add(true);
  }
  missing_seen_ = missing;
  missing_.Add(false);
  frame.image.arrival = frame.image.arrival + system_.monotonic_offset;
  const auto message =
      maker_->Make(frame.image, frame.depth ? &*frame.depth : nullptr, camera_->set_exposure_us());
  ControlExposure();
  if (!message) return;
  Publish(wire::kCamera, wire::Encode(*message));
  health_.AddLatency(system_.now() - now);
}

void CameraNode::ControlExposure() {
  if (!exposure_) return;
  const auto setting = exposure_->Observe(maker_->brightness().mean);
  if (setting && !camera_->SetExposure(*setting)) health_.Count("camera.exposure_refused");
}

void CameraNode::Publish(const char* channel, const std::vector<uint8_t>& message) {
  if (bus_ == nullptr) return;
  if (!bus_->Publish(channel, message)) health_.Count("camera.publish_failed");
}

std::vector<std::string> CameraNode::Warnings() const {
  std::vector<std::string> out;
  if (!camera_) return out;
  if (found_.usb2()) {
    out.emplace_back(
        "usb2: the camera is on a USB 2 link: push the plug in fully, use a USB 3 port "
        "and cable");
  }
  if (maker_->dots_seen()) {
    out.emplace_back(
        "emitter: the image shows the projector's dots: set drivers.camera.emitter: "
        "off, or find the other projector");
  }
  if (maker_->under_exposed()) {
    out.emplace_back(
        "dark: the image is under-exposed: more light, or a larger "
        "drivers.camera.exposure_us");
  }
  if (missing_.share() > kManyMissing) {
    out.emplace_back("lost: more than one image in twenty is lost: check cable and load");
  }
  if (config_.drivers.camera.source == CameraSource::kRealsense && !camera_->has_metadata()) {
    out.emplace_back("times: no metadata node, image times are those of arrival");
  }
  if (motion_.skewed()) {
    out.push_back("skew: IMU samples are " + std::to_string(motion_.lag().least()->us / 1000) +
                  " ms old when they arrive: their clock is not the camera's");
  }
  if (motion_.wanted() && !motion_.open() && !motion_error_.empty()) {
    out.push_back("imu: " + motion_error_);
  }
  if (!device_error_.empty()) out.push_back("device: the camera reports: " + device_error_);
  return out;
}

void CameraNode::UpdateHealth() {
  UpdateCounters();
  if (!camera_) {
    health_.SetState(HealthState::kFailed, absent_->message);
    return;
  }
  if (maker_->counters().made == 0) {
    health_.SetState(HealthState::kStarting, "waiting for the first images");
    return;
  }
  const std::string warnings = Join(Warnings());
  health_.SetState(warnings.empty() ? HealthState::kOk : HealthState::kDegraded, warnings);
}

void CameraNode::UpdateCounters() {
  const auto set = [this](const std::string& name, int64_t value) {
    health_.SetCounter(name, value);
  };
  const StreamCounters stream = camera_ ? Sum(closed_, camera_->counters()) : closed_;
  set("camera.images", stream.images);
  set("camera.lost", stream.lost);
  set("camera.bad", stream.bad);
  set("camera.depth_lost", stream.depth_lost);
  set("camera.depth_bad", stream.depth_bad);
  set("camera.metadata_bad", stream.metadata_bad);
  set("camera.without_metadata", stream.without_metadata);
  set("camera.unpaired", stream.unpaired);
  set("camera.opens", opens_);
  set("camera.restarts", recovery_.restarts());
  set("camera.usb_resets", recovery_.resets());
  if (maker_) {
    set("camera.published", maker_->counters().made);
    set("camera.untimed", maker_->counters().untimed);
    set("camera.lit", maker_->counters().lit);
    set("camera.clock_restarts", maker_->clock().restarts());
    set("camera.clock_steps", maker_->clock().device_clock().steps());
  }
  set("imu.dropped", motion_.merger().dropped());
  set("imu.without_accel", motion_.merger().without_accel());
}

}  // namespace gw::camera

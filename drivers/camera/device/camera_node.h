// The program gw-camera without its main(): a camera and its IMU on a bus. It opens, watches,
// restarts, resets and reopens the camera, and says in HEALTH what is wrong and what to do.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/config/robot_config.h"
#include "common/core/result.h"
#include "common/process/bus.h"
#include "common/process/health_reporter.h"
#include "common/process/log_line.h"
#include "drivers/camera/core/exposure_control.h"
#include "drivers/camera/core/frame_maker.h"
#include "drivers/camera/core/recovery.h"
#include "drivers/camera/device/camera.h"
#include "drivers/camera/device/find_camera.h"
#include "drivers/camera/device/motion_unit.h"

namespace gw::camera {

class CameraNode {
 public:
  // What the node needs of the system; tests bring their own.
  struct System {
    SystemCalls* calls = nullptr;
    SystemRoots roots;
    std::function<Utime()> now;
    DurationUs monotonic_offset;  // what `now` is ahead of CLOCK_MONOTONIC
    std::function<Result<Done>(int bus, int address)> reset_usb;
  };

  // `bus` must outlive the node; it is null for --check, which publishes nothing.
  CameraNode(const RobotConfig& config, process::Bus* bus, System system, process::LogLine log);

  // The descriptors to wait for; they change with every call of Read() and Tick().
  std::vector<int> fds() const;
  // To be called when one of the descriptors is readable or has failed.
  void Read(int fd);
  // To be called every 20 ms: opens the camera, recovers it, publishes HEALTH.
  void Tick();

  // The reason why a camera that is there cannot be made to deliver. The process has to end with
  // exit code 1 then; another one may have more luck, or the machine needs help.
  const std::optional<std::string>& gave_up() const { return gave_up_; }

  bool streaming() const { return camera_ != nullptr; }
  // The reason why there is no camera.
  const std::optional<Error>& absent() const { return absent_; }
  // Everything that is not as it should be although images come.
  std::vector<std::string> Warnings() const;
  const FoundCamera& found() const { return found_; }
  Camera* camera() { return camera_.get(); }
  const MotionUnit& motion() const { return motion_; }
  int64_t frames() const { return maker_ ? maker_->counters().made : 0; }

 private:
  void OpenCamera();
  void CloseCamera(const std::string& why);
  void OpenMotion();
  void CloseMotion(const std::string& why);
  void Recover(Remedy remedy);
  void Deliver(CapturedFrame frame, Utime now);
  void ControlExposure();
  void PollDeviceError();
  void Publish(const char* channel, const std::vector<uint8_t>& message);
  void UpdateHealth();
  void UpdateCounters();

  RobotConfig config_;
  process::Bus* bus_;
  System system_;
  process::LogLine log_;
  process::HealthReporter health_;

  FoundCamera found_;
  std::unique_ptr<Camera> camera_;
  StreamCounters closed_;  // counters of the cameras that were closed before this one
  std::optional<FrameMaker> maker_;
  std::optional<ExposureControl> exposure_;
  MotionUnit motion_;
  std::string motion_error_;
  Recovery recovery_;
  RecentShare missing_{300};  // share of the newest images that were lost or bad
  int64_t missing_seen_ = 0;
  std::string device_error_;

  std::optional<Error> absent_ = Error{ErrorCode::kIo, "the camera is not open yet"};
  std::optional<Utime> retry_;
  bool waiting_for_remedy_ = false;  // the camera failed, and recovery_ decides when to try again
  std::optional<Utime> motion_retry_;
  std::optional<Utime> device_error_asked_;
  std::optional<std::string> gave_up_;
  int64_t opens_ = 0;
};

}  // namespace gw::camera

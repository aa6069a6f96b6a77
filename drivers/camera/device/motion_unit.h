// The motion module of a D435i: gyro and accelerometer, as one IMU.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/config/robot_config.h"
#include "common/contract/samples.h"
#include "drivers/camera/core/imu_merger.h"
#include "drivers/camera/core/lag_check.h"
#include "drivers/camera/device/find_camera.h"
#include "drivers/camera/device/motion_sensor.h"
#include "drivers/camera/protocol/hardware_monitor.h"

namespace gw::camera {

class MotionUnit {
 public:
  // `monotonic_offset` is what the robot's clock is ahead of CLOCK_MONOTONIC.
  MotionUnit(const RobotConfig& config, DurationUs monotonic_offset);

  // True when the configuration asks for the camera's IMU.
  bool wanted() const { return wanted_; }
  // Opens both sensors. Errors: those of the sensors; kNotFound when the camera has none.
  Result<Done> Open(const FoundCamera& found, const FirmwareVersion& firmware,
                    const SystemRoots& roots, Utime now);
  void Close();
  bool open() const { return gyro_.has_value(); }

  std::vector<int> fds() const;
  // The samples that are complete, with seq counting from 1 over all openings. Error kIo: a sensor
  // is gone.
  Result<std::vector<ImuSample>> Read(int fd, Utime now);

  // True when the sensors are open but no gyro sample came for a second.
  bool silent(Utime now) const { return open() && now - last_gyro_ > Milliseconds(1000); }
  bool skewed() const { return lag_.skewed(); }
  const LagCheck& lag() const { return lag_; }
  const ImuMerger& merger() const { return merger_; }

 private:
  bool wanted_;
  int gyro_rate_hz_;
  int accel_rate_hz_;
  DurationUs monotonic_offset_;
  FirmwareVersion firmware_;
  std::optional<MotionSensor> gyro_, accel_;
  ImuMerger merger_;
  LagCheck lag_;
  Utime last_gyro_;
};

}  // namespace gw::camera

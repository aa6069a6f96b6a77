#include "drivers/camera/device/motion_unit.h"

#include <cmath>
#include <utility>

#include "drivers/camera/protocol/motion_units.h"

namespace gw::camera {

MotionUnit::MotionUnit(const RobotConfig& config, DurationUs monotonic_offset)
    : wanted_(config.drivers.camera.source == CameraSource::kRealsense &&
              config.drivers.camera.publish_imu && config.calibration.imu.present),
      gyro_rate_hz_(static_cast<int>(std::lround(config.calibration.imu.rate_hz))),
      accel_rate_hz_(static_cast<int>(config.drivers.camera.accel_rate_hz)),
      monotonic_offset_(monotonic_offset) {}

Result<Done> MotionUnit::Open(const FoundCamera& found, const FirmwareVersion& firmware,
                              const SystemRoots& roots, Utime now) {
  if (found.gyro.empty() || found.accel.empty()) {
    return Error{ErrorCode::kNotFound,
                 "the camera shows no motion sensors: load the kernel modules hid-sensor-gyro-3d "
                 "and hid-sensor-accel-3d, or set drivers.camera.publish_imu: false"};
  }
  const auto gyro_code = SamplingFrequencyCode(gyro_rate_hz_);
  if (!gyro_code || gyro_rate_hz_ < 200) {
    return Error{ErrorCode::kBadConfig,
                 "calibration.imu.rate_hz = " + std::to_string(gyro_rate_hz_) +
                     ": the gyro of the camera has 200 and 400"};
  }
  auto gyro = MotionSensor::Open(found.gyro, "in_anglvel", *gyro_code, roots);
  if (!gyro) return gyro.error();
  auto accel = MotionSensor::Open(found.accel, "in_accel",
                                  SamplingFrequencyCode(accel_rate_hz_).value(), roots);
  if (!accel) return accel.error();
  gyro_.emplace(std::move(*gyro));
  accel_.emplace(std::move(*accel));
  firmware_ = firmware;
  last_gyro_ = now;
  lag_ = {};
  return Done{};
}

void MotionUnit::Close() {
  gyro_.reset();
  accel_.reset();
}

std::vector<int> MotionUnit::fds() const {
  if (!open()) return {};
  return {gyro_->fd(), accel_->fd()};
}

Result<std::vector<ImuSample>> MotionUnit::Read(int fd, Utime now) {
  const bool is_gyro = fd == gyro_->fd();
  const auto rows = is_gyro ? gyro_->Read() : accel_->Read();
  if (!rows) return rows.error();
  std::vector<ImuSample> out;
  for (const MotionRow& row : *rows) {
    const Utime utime = Utime{row.timestamp_ns / 1000} + monotonic_offset_;
    lag_.Add(utime, now);
    std::vector<ImuSample> samples;
    if (is_gyro) {
      last_gyro_ = now;
      samples = merger_.AddGyro({utime, GyroFromRaw(row.raw, firmware_)});
    } else {
      samples = merger_.AddAccel({utime, AccelFromRaw(row.raw)});
    }
    out.insert(out.end(), samples.begin(), samples.end());
  }
  return out;
}

}  // namespace gw::camera

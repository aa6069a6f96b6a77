// One motion sensor (gyro_3d or accel_3d) of the industrial I/O subsystem: set up through sysfs,
// read as rows from its node.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "common/process/file_handle.h"
#include "drivers/camera/device/find_camera.h"
#include "drivers/camera/protocol/iio_buffer.h"

namespace gw::camera {

struct MotionRow {
  std::array<int64_t, 3> raw{};  // in the axes of the sensor
  int64_t timestamp_ns = 0;      // CLOCK_MONOTONIC
};

class MotionSensor {
 public:
  // `folder` is the one in sysfs, .../iio:device0; `prefix` is "in_anglvel" or "in_accel";
  // `frequency_code` is that of motion_units.h. Errors: kIo (no permission, in use), kBadData
  // (channels that are not three axes and a time); the text says what to do.
  static Result<MotionSensor> Open(const std::string& folder, const std::string& prefix,
                                   int frequency_code, const SystemRoots& roots);
  MotionSensor(MotionSensor&&) = default;
  MotionSensor& operator=(MotionSensor&&) = delete;
  ~MotionSensor();

  int fd() const { return node_.get(); }
  // The rows that have arrived. Error kIo: the device is gone.
  Result<std::vector<MotionRow>> Read();

 private:
  MotionSensor(std::string folder, IioLayout layout, std::array<int, 4> places,
               process::FileHandle node)
      : folder_(std::move(folder)),
        layout_(std::move(layout)),
        places_(places),
        node_(std::move(node)) {}

  std::string folder_;
  IioLayout layout_;
  std::array<int, 4> places_;  // places of x, y, z and the time in a decoded row
  process::FileHandle node_;
  std::vector<uint8_t> partial_;  // the bytes of a row whose rest has not arrived yet
};

}  // namespace gw::camera

// Everything that the checks need of a log, read in one pass.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/config/robot_config.h"
#include "common/contract/samples.h"
#include "tools/data/log/log_clock.h"
#include "tools/lab/check/image_facts.h"

namespace gw::check {

struct Stream {
  std::vector<Utime> times;  // of the messages, in the order of the log
  int64_t undecodable = 0;
  std::string why_undecodable;  // of the first
};

struct LogFacts {
  std::map<std::string, Stream> streams;  // CAMERA, IMU, WHEEL
  std::vector<ImuSample> imu;
  std::vector<WheelSample> wheels;
  ImageFacts images;
  std::vector<tools::TimeStep> time_steps;
  bool truncated = false;
  int64_t skipped_bytes = 0;
};

// Error: kNotFound, kIo.
Result<LogFacts> ReadLogFacts(const std::string& log, const CameraGeometry& geometry);

}  // namespace gw::check

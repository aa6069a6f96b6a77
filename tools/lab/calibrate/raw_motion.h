// The samples of wheels and IMU of a log; its images are counted.
#pragma once

#include <string>
#include <vector>

#include "common/contract/samples.h"
#include "common/core/result.h"

namespace gw::calibrate {

struct RawMotion {
  std::vector<WheelSample> wheels;
  std::vector<ImuSample> imu;
  int images = 0;
};

// Error: kNotFound, kIo.
Result<RawMotion> ReadMotion(const std::string& log);

}  // namespace gw::calibrate

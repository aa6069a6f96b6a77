// Faults of the sensors of motion: wheels, gyro, dead reckoning.
#pragma once

#include <cstdint>
#include <optional>

#include "common/contract/dead_reckoning.h"
#include "common/contract/samples.h"

namespace gw::fault {

// Streams must be given whole and in time order, with cut = true for what a teleport leaves out
// (the result is then to be ignored). Times of the results are those of the input.
class WheelFaults {
 public:
  WheelSample Apply(const WheelSample& sample, double slip_factor, bool cut);

 private:
  struct Encoder {
    uint16_t last = 0;
    double offset = 0;  // what the output counts more than the input
    uint16_t Step(uint16_t ticks, double factor);
  };
  std::optional<WheelSample> last_;
  Encoder left_, right_;
  double heading_offset_rad_ = 0;
};

class DrFaults {
 public:
  DrState Apply(const DrState& state, double slip_factor, bool cut);

 private:
  std::optional<DrState> last_;  // of the input
  SE3 T_OB_out_;                 // of the output, at last_
  bool edited_ = false;          // from here on the output is composed anew
};

}  // namespace gw::fault

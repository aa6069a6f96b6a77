// Wheel increments from the counts of two encoders, as they were read.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/contract/samples.h"
#include "common/core/result.h"

namespace gw::importer {

struct EncoderBase {
  double ticks_per_metre = 0;  // of wheel travel
  double track_m = 0;          // between the two driven wheels
};

// Motion of a differential drive whose wheels went so far (m): the arc of way (l + r) / 2 and turn
// (r - l) / track, into dx_m, dy_m and dyaw_rad.
void SetArc(double left_m, double right_m, double track_m, WheelSample& sample);

// Lines `t_s left right`: counts since the start, of any size. The increment between two readings
// is the arc of a differential drive: way (l + r) / 2, turn (r - l) / track. The body is the middle
// of the axle. Error: those of a text table; kBadData when fewer than two readings are of use.
Result<std::vector<WheelSample>> ReadEncoders(const std::filesystem::path& file,
                                              const EncoderBase& base,
                                              std::vector<std::string>& warnings);

}  // namespace gw::importer

// Named faults of the sensors of motion: wheels, IMU, recorded dead reckoning.
#pragma once

#include <functional>
#include <vector>

#include "common/contract/dead_reckoning.h"
#include "common/contract/samples.h"
#include "tools/data/fault/named_fault.h"

namespace gw::fault {

template <typename Sample>
struct Edited {
  Sample sample;
  DurationUs delay;  // received later than the sample it was made from
};

// Edits what has become of one message of a stream: given whole and in the order of the log.
// inside: the message lies in the span of the fault.
template <typename Sample>
using SampleFault = std::function<void(bool inside, std::vector<Edited<Sample>>& samples)>;

// Empty: the fault does not concern the stream.
SampleFault<WheelSample> MakeWheelFault(FaultId id);
SampleFault<ImuSample> MakeImuFault(FaultId id);
SampleFault<DrState> MakeDrFault(FaultId id);

}  // namespace gw::fault

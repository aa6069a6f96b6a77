// Faults of the camera.
#pragma once

#include "common/wire/wire.h"
#include "tools/data/fault/fault_injector.h"

namespace gw::fault {

class ImageFaults {
 public:
  explicit ImageFaults(const FaultPlan& plan) : plan_(plan) {}

  // True when the message at this time since the begin of the log is lost.
  bool Lost(DurationUs since_begin, int64_t seq) const;
  // True when the images change at this time.
  bool Touches(DurationUs since_begin) const;
  // To be called with every camera message, in time order: a freeze shows the last one before it.
  void Remember(DurationUs since_begin, const wire::Bytes& message);
  // The frame with its faults, encoded.
  wire::Bytes Apply(DurationUs since_begin, CameraFrame frame, FaultSummary& summary) const;

 private:
  const FaultPlan& plan_;
  wire::Bytes last_before_freeze_;  // empty: none yet
};

}  // namespace gw::fault

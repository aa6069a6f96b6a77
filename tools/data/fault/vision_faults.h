// Named faults of the camera.
#pragma once

#include <optional>
#include <vector>

#include "tools/data/fault/camera_images.h"
#include "tools/data/fault/named_fault.h"

namespace gw::fault {

class VisionFaults {
 public:
  // Applies those of `faults` that are of the camera, one after the other.
  VisionFaults(const std::vector<NamedFault>& faults, const CameraOptics& optics);

  bool empty() const { return faults_.empty(); }
  // To be called with every frame, in the order of the log. Empty: the frame stays as it is.
  std::optional<wire::Bytes> Apply(DurationUs since_begin, const CameraFrame& frame);

 private:
  void Edit(const NamedFault& fault, DurationUs since_begin, CameraImages* images) const;

  std::vector<NamedFault> faults_;
  CameraOptics optics_;
  CameraImages previous_;  // as they came
  int64_t frames_ = 0;
};

}  // namespace gw::fault

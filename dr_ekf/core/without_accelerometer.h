// From a filter that used the accelerometer to one that never did: the pose is that of before, all
// that is known besides is what wheels and gyro tell
// (docs/adr/0062-an-unfit-stream-takes-its-lessons-along.md).
#pragma once

#include "common/core/se3.h"
#include "dr_ekf/core/filter_state.h"

namespace gw::dr_ekf {

// From the frame O of a twin to the one of the filter that it replaces.
struct TwinFrame {
  SE3 T_O_twin;
  // Both filters had the same samples: where the twin is instead is what may be wrong with the pose
  // that is kept, one sigma. Perturbation of the frame, in O.
  Vector6d error = Vector6d::Zero();
  // The filter had come to a tilt that no floor has. It is gone in one step, which is no motion:
  // reset_counter moves on.
  bool levelled = false;
};

// T_OB: of the filter, T_OB_twin: of its twin, at one instant. most_tilt: rad, that a floor has.
TwinFrame FrameOfTwin(const SE3& T_OB, const SE3& T_OB_twin, double most_tilt);

// The twin's state (S is B) in the place of `before`, which is of the same instant.
FilterState GoOnAsTwin(const FilterState& twin, const TwinFrame& frame, const FilterState& before);

}  // namespace gw::dr_ekf

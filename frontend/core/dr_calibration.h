// What healthy vision teaches about dead reckoning (DR), for the time when there is none.
//
// Scale errors make most of the drift of a wheeled robot: the sensitivity of a gyro is off by up to
// some per cent (BMI055, L3G4200D datasheets: 1 to 3 %), the radius of wheels likewise. The filter
// cannot see them, wheels and gyro do not know better. The map does: one scalar Kalman filter each,
//
//   theta_vision = (1 + s) theta_dr + n       heading: rotation about body z over a window
//   x_vision     = (1 + k) x_dr + n           way: translation along body x
//
// Errors of the camera's own calibration enter as well: DR then agrees with the map that the robot
// comes back into, which is what a blind span needs.
#pragma once

#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw::frontend {

class DrCalibration {
 public:
  // The motion without the scale errors known so far. Body frame.
  SE3 Corrected(const SE3& T_BaBb) const;

  // The body's motion between two images in a row that vision carries in full health, as DR tells
  // it (not corrected) and as vision measured it.
  void Observe(const SE3& T_BaBb_dr, const SE3& T_BaBb_vision, DurationUs interval);
  // Between two images vision was not healthy, or DR has doubts of its own (slip).
  void Interrupt() { window_ = Window(); }

  double heading_scale() const { return 1 + heading_.error; }
  double way_scale() const { return 1 + way_.error; }

 private:
  // Motions are compared over windows: the noise of vision then counts at their ends only.
  struct Window {
    SE3 dr, vision;
    DurationUs length{0};
  };
  struct Scale {
    double error = 0;  // the true motion is (1 + error) times that of DR
    double variance;
    // sigma: of measured, beside the scale. What is far off is not used.
    void Update(double dr, double measured, double sigma);
  };

  Window window_;
  Scale heading_{.variance = 0.01 * 0.01};
  Scale way_{.variance = 0.02 * 0.02};
};

}  // namespace gw::frontend

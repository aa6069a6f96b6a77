// A smooth way through poses: the cumulative cubic B-spline on SE(3), uniform in time.
//
// Lovegrove, Patron-Perez, Sibley, "Spline Fusion", BMVC 2013, equation 4:
//   T(t) = T_i  Exp(b1(u) d1)  Exp(b2(u) d2)  Exp(b3(u) d3),   d_j = Log(inv(T_(i+j-1)) T_(i+j))
//   b1 = (5 + 3u - 3u^2 + u^3) / 6,  b2 = (1 + 3u + 3u^2 - 2u^3) / 6,  b3 = u^3 / 6
// with u in [0, 1) the share of the span between two knots that has passed. It is twice
// continuously differentiable, and each pose depends on four control poses.
#pragma once

#include <vector>

#include "common/core/time.h"
#include "tools/lab/eval/trajectory.h"

namespace gw::eval {

class PoseSpline {
 public:
  // From begin to end, `spacing` between knots; all control poses are the identity.
  // Precondition: begin <= end, spacing > 0.
  PoseSpline(Utime begin, Utime end, DurationUs spacing);

  // Where a time lies: its first control pose, and u. Times beyond the ends: those of the ends.
  struct Place {
    size_t first = 0;
    double u = 0;
  };
  Place At(Utime t) const;
  // When control pose i counts most.
  Utime TimeOf(size_t control) const;

  SE3 Pose(Utime t) const;
  // Rate of rotation in the body frame, rad/s.
  Eigen::Vector3d Rate(Utime t) const;

  double spacing_s() const { return spacing_.seconds(); }
  std::vector<SE3>& controls() { return controls_; }
  const std::vector<SE3>& controls() const { return controls_; }

 private:
  Utime begin_;
  Utime end_;
  DurationUs spacing_;
  std::vector<SE3> controls_;  // at least 4
};

}  // namespace gw::eval

// Ties the frame of the ground truth G to the world W of the map: the rotation about the vertical
// and the translation that fit all pairs of poses so far, in closed form, updated with every pair.
//
// Minimises over (yaw, t):  sum |Rz(yaw) p_GB + t - p_WB|^2 / sigma_p^2 + |heading difference|^2 /
// sigma_h^2, the second term as 2 - 2 cos, so that both have their optimum in the angle of one
// complex sum (Horn, "Closed-form solution of absolute orientation using unit quaternions", JOSA A
// 4(4), 1987, for the vertical axis alone). With one pair the heading decides; with a long way the
// positions do.
#pragma once

#include <complex>
#include <cstdint>
#include <optional>

#include "common/core/se3.h"

namespace gw::foxglove {

class TruthTie {
 public:
  void Add(const SE3& T_WB, const SE3& T_GB);
  bool tied() const { return count_ > 0; }
  // Precondition: tied().
  SE3 T_WG() const;

 private:
  int64_t count_ = 0;
  // Running means, and the sum of products about them: numerically stable, of constant size.
  Eigen::Vector3d mean_W_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_G_ = Eigen::Vector3d::Zero();
  std::complex<double> cross_ = 0;    // sum conj(g) w of centred horizontal positions
  std::complex<double> heading_ = 0;  // sum exp(i (yaw of W - yaw of G))
};

// Rotation about the vertical that is nearest to q.
double YawOf(const Eigen::Quaterniond& q);

}  // namespace gw::foxglove

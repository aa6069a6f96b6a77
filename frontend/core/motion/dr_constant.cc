#include "frontend/core/motion/dr_constant.h"

#include <cmath>

namespace gw::frontend {

void DrConstant::Take(const DrExplanation& explained) {
  const auto way = explained.way.value_or(std::polar(way_factor_, direction_));
  const DrConstantFault fault =
      FaultOf(std::abs(way), std::arg(way), explained.turn.value_or(turn_factor_));
  way_factor_ = fault.way_factor.value_or(1);
  direction_ = fault.direction.value_or(0);
  turn_factor_ = fault.turn_factor.value_or(1);
}

DrConstantFault DrConstant::Beside(const DrConstant& other) const {
  return FaultOf(way_factor_ / other.way_factor_,
                 std::remainder(direction_ - other.direction_, 2 * M_PI),
                 turn_factor_ / other.turn_factor_);
}

DrState DrConstant::Follow(const DrState& before, const DrState& told_before,
                           const DrState& told) const {
  Matrix6d A = Matrix6d::Identity();
  A.topLeftCorner<3, 3>() = way_factor_ * ExpSO3({0, 0, direction_}).toRotationMatrix();
  A(5, 5) = turn_factor_;
  const SE3 step = told_before.T_OB.inverse() * told.T_OB;
  Eigen::Vector3d turn = LogSO3(step.rotation());
  turn.z() *= turn_factor_;

  DrState out = told;
  out.T_OB = before.T_OB * SE3(ExpSO3(turn), A.topLeftCorner<3, 3>() * step.translation());
  out.v_OB_B = A.topLeftCorner<3, 3>() * told.v_OB_B;
  out.w_OB_B.z() *= turn_factor_;
  out.way_scale_sigma = std::hypot(told.way_scale_sigma, DrDisagreement::kFactorSigma);
  if (turn_factor_ != 1)
    out.turn_scale_sigma = std::hypot(told.turn_scale_sigma, DrDisagreement::kFactorSigma);
  for (Matrix6d* cov : {&out.cov_T_OB, &out.cov_twist_white, &out.cov_twist_coherent}) {
    *cov = (A * *cov * A.transpose()).eval();
  }
  return out;
}

}  // namespace gw::frontend

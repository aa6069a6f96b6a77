// SE(3) and our residuals in Ceres' terms. Only .cc files and tests of the back-end include this.
//
// A pose T_WC is a parameter block of 7: quaternion x y z w, then translation; its tangent is our
// [translation; rotation] on the right, T * Exp(d).
#pragma once

#include <ceres/manifold.h>
#include <ceres/sized_cost_function.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "common/core/se3.h"
#include "common/good_weights/camera_motion.h"
#include "common/vision/reprojection.h"

namespace gw::backend {

using PoseBlock = std::array<double, 7>;

PoseBlock ToBlock(const SE3& T);
SE3 FromBlock(const double* block);

class PoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

// Blocks: pose T_WC (7), point p_W (3). Evaluation fails when the point is not in front of the
// camera, which makes the solver take a shorter step. kRows 2: (u, v); 3: (u, v, disparity).
//
// Robust by itself, to be used without a loss function: pixel and depth have a Huber cost each,
// which a single loss over the block cannot express. A part r of the residual with s = |r|^2 beyond
// the Huber radius is scaled by g(s) = sqrt(HuberCost(s) / s), so that its square is the Huber
// cost.
template <int kRows>
class ReprojectionCost final : public ceres::SizedCostFunction<kRows, 7, 3> {
 public:
  // The camera must outlive the cost.
  ReprojectionCost(const RectifiedCamera* camera, const PixelObservation& observation)
      : camera_(camera), observation_(observation) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const RectifiedCamera* camera_;
  PixelObservation observation_;
};

// Blocks: T_WCa, T_WCb. Residual: sqrt_information * Log(inv(T_CaCb) * inv(T_WCa) * T_WCb).
class RelativePoseCost final : public ceres::SizedCostFunction<6, 7, 7> {
 public:
  RelativePoseCost(const SE3& T_CaCb, const Matrix6d& sqrt_information)
      : T_CbCa_(T_CaCb.inverse()), sqrt_information_(sqrt_information) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  SE3 T_CbCa_;
  Matrix6d sqrt_information_;
};

// The same with a third block, the errors of the scales of way and turn (2): the motion is
// T_CaCb * Exp(lever * errors).
class ScaledMotionCost final : public ceres::SizedCostFunction<6, 7, 7, 2> {
 public:
  ScaledMotionCost(const SE3& T_CaCb, const ScaleLever& lever, const Matrix6d& sqrt_information)
      : T_CaCb_(T_CaCb), lever_(lever), sqrt_information_(sqrt_information) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  SE3 T_CaCb_;
  ScaleLever lever_;
  Matrix6d sqrt_information_;
};

// Block: T_WC. Residual: by how many sigmas the origin of the body is above z_W.
class HeightCost final : public ceres::SizedCostFunction<1, 7> {
 public:
  HeightCost(const SE3& T_BC, double z_W, double sigma)
      : p_CB_(T_BC.inverse().translation()), z_W_(z_W), sigma_(sigma) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Vector3d p_CB_;
  double z_W_;
  double sigma_;
};

// Block: the errors of the scales (2). Residual: the errors in sigmas. (ceres::NormalPrior holds
// Eigen's dynamic matrices, whose memory another build of Eigen inside Ceres may lay out
// otherwise.)
class ScalePrior final : public ceres::SizedCostFunction<2, 2> {
 public:
  explicit ScalePrior(double sigma) : inverse_sigma_(1 / sigma) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  double inverse_sigma_;
};

}  // namespace gw::backend

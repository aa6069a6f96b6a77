#include "backend/core/bundle/landmark_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/vision/huber.h"

namespace gw::backend {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kIterations = 50;
constexpr double kConverged = 1e-6;  // relative change of the cost
constexpr double kFirstDamping = 1e-4, kLeastDamping = 1e-6, kMostDamping = 1e3;

struct NormalEquations {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  double cost = 0;  // infinity behind a camera; the rest is not complete then
  double least_depth = kInfinity;
};

NormalEquations Linearize(const RectifiedCamera& camera,
                          std::span<const PosedObservation> observations,
                          const Eigen::Vector3d& p_W) {
  NormalEquations out;
  for (const PosedObservation& o : observations) {
    const Eigen::Vector3d p_C = o.T_CW * p_W;
    if (!(p_C.z() > kMinProjectionDepth)) {
      out.cost = kInfinity;
      return out;
    }
    const Eigen::Vector3d r = ReprojectionResidual(camera, o.pixel, p_C);
    const Eigen::Matrix3d J =
        ReprojectionJacobian(camera, o.pixel, p_C) * o.T_CW.rotation().toRotationMatrix();
    const double pixel = r.head<2>().squaredNorm();
    const double depth = r[2] * r[2];
    const double pixel_weight = HuberWeight(pixel, kChi2Pixel);
    const Eigen::Vector3d weight(pixel_weight, pixel_weight, HuberWeight(depth, kChi2Depth));
    out.H += J.transpose() * weight.asDiagonal() * J;
    out.g += J.transpose() * weight.cwiseProduct(r);
    out.cost += HuberCost(pixel, kChi2Pixel) + HuberCost(depth, kChi2Depth);
    out.least_depth = std::min(out.least_depth, p_C.z());
  }
  return out;
}

double Vagueness(const NormalEquations& at) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(at.H, Eigen::EigenvaluesOnly);
  const double least_information = solver.eigenvalues()[0];
  return least_information > 0 ? 1 / (std::sqrt(least_information) * at.least_depth) : kInfinity;
}

}  // namespace

LandmarkFit FitLandmark(const RectifiedCamera& camera,
                        std::span<const PosedObservation> observations,
                        const Eigen::Vector3d& start) {
  Eigen::Vector3d p_W = start;
  NormalEquations at = Linearize(camera, observations, p_W);
  if (!std::isfinite(at.cost)) return {start, kInfinity};
  double damping = kFirstDamping;
  for (int i = 0; i < kIterations && damping < kMostDamping; ++i) {
    Eigen::Matrix3d H = at.H;
    H.diagonal() *= 1 + damping;
    const Eigen::Vector3d next_p_W = p_W - H.ldlt().solve(at.g);
    const NormalEquations next = Linearize(camera, observations, next_p_W);
    if (!(next.cost < at.cost)) {
      damping *= 10;
      continue;
    }
    const bool converged = at.cost - next.cost < kConverged * at.cost;
    p_W = next_p_W;
    at = next;
    if (converged) break;
    damping = std::max(kLeastDamping, damping / 10);
  }
  return {p_W, Vagueness(at)};
}

}  // namespace gw::backend

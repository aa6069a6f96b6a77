#include "common/vision/pose_optimizer.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "common/vision/huber.h"

namespace gw {
namespace {

constexpr int kRounds = 4;
constexpr int kIterations = 10;
constexpr double kMinDepth = 1e-2;  // m; nearer points have no usable Jacobian

// What the last round made of an observation.
enum Use : uint8_t { kNotUsed = 0, kPixelOnly = 1, kPixelAndDepth = 2 };

struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  double cost = 0;
};

template <typename JacobianRows, typename ResidualRows>
void AddRows(const JacobianRows& J, const ResidualRows& e, double w, double limit, bool robust,
             NormalEquations* out) {
  const double chi2 = w * e.squaredNorm();
  const double weight = robust ? w * HuberWeight(chi2, limit) : w;
  out->cost += robust ? HuberCost(chi2, limit) : chi2;
  for (int r = 0; r < J.rows(); ++r) {
    const Vector6d j = J.row(r).transpose();
    out->H.template selfadjointView<Eigen::Lower>().rankUpdate(j, weight);
    out->g += (weight * e[r]) * j;
  }
}

// Accumulates the observations in use. `robust`: Huber weights, else plain squares.
NormalEquations Linearize(const RectifiedCamera& camera, const SE3& T_WC,
                          const std::vector<PoseObservation>& observations,
                          const std::vector<uint8_t>& use, bool robust) {
  NormalEquations out;
  const SE3 T_CW = T_WC.inverse();
  Eigen::Vector3d e;
  Eigen::Matrix<double, 3, 6> J;
  for (size_t i = 0; i < observations.size(); ++i) {
    if (use[i] == kNotUsed) continue;
    const int rows = ReprojectionResidual(camera, T_CW, observations[i], &e, &J);
    if (rows == 0) {
      out.cost += kChi2Stereo;
      continue;
    }
    const double w = observations[i].inverse_sigma2;
    // Pixel and depth fail for different reasons (a wrong match; a depth edge), so each has its
    // loss.
    AddRows(J.topRows<2>(), e.head<2>(), w, kChi2Mono, robust, &out);
    if (rows == 3 && use[i] == kPixelAndDepth) {
      AddRows(J.bottomRows<1>(), e.tail<1>(), w, kChi2Depth, robust, &out);
    }
  }
  out.H = out.H.selfadjointView<Eigen::Lower>();
  return out;
}

void AddPrior(const PosePrior& prior, const SE3& T_WC, NormalEquations* equations) {
  const Vector6d r = (prior.T_WC.inverse() * T_WC).Log();
  const Matrix6d J = RightJacobianInverseSE3(r);
  equations->H += J.transpose() * prior.information * J;
  equations->g += J.transpose() * (prior.information * r);
  equations->cost += r.dot(prior.information * r);
}

}  // namespace

int ReprojectionResidual(const RectifiedCamera& camera, const SE3& T_CW, const PoseObservation& o,
                         Eigen::Vector3d* residual, Eigen::Matrix<double, 3, 6>* jacobian) {
  const Eigen::Vector3d p = T_CW * o.p_W;
  if (p.z() < kMinDepth) return 0;
  const double iz = 1.0 / p.z();
  const double x = p.x() * iz;
  const double y = p.y() * iz;
  const double u = camera.fx * x + camera.cx;
  const double v = camera.fy * y + camera.cy;
  (*residual)[0] = u - o.u;
  (*residual)[1] = v - o.v;
  // d p_C / d [rho, phi] = [-I, Skew(p_C)] for T_WC * Exp([rho, phi]), chained with the projection.
  auto& J = *jacobian;
  J(0, 0) = -camera.fx * iz;
  J(0, 1) = 0;
  J(0, 2) = camera.fx * x * iz;
  J(0, 3) = camera.fx * x * y;
  J(0, 4) = -camera.fx * (1.0 + x * x);
  J(0, 5) = camera.fx * y;
  J(1, 0) = 0;
  J(1, 1) = -camera.fy * iz;
  J(1, 2) = camera.fy * y * iz;
  J(1, 3) = camera.fy * (1.0 + y * y);
  J(1, 4) = -camera.fy * x * y;
  J(1, 5) = -camera.fy * x;
  if (!o.has_right) return 2;
  // u_right = u - bf / z: adds bf / z^2 times the depth row (0, 0, -1, -p_y, p_x, 0) of [-I,
  // Skew(p_C)].
  const double k = camera.bf() * iz * iz;
  (*residual)[2] = u - camera.bf() * iz - o.u_right;
  J.row(2) = J.row(0);
  J(2, 2) -= k;
  J(2, 3) -= k * p.y();
  J(2, 4) += k * p.x();
  return 3;
}

PoseEstimate OptimizePose(const RectifiedCamera& camera, const SE3& T_WC_start,
                          const std::vector<PoseObservation>& observations,
                          const std::optional<PosePrior>& prior) {
  PoseEstimate out;
  out.T_WC = observations.empty() && prior ? prior->T_WC : T_WC_start;
  out.inlier.assign(observations.size(), 1);
  std::vector<uint8_t> use(observations.size(), kPixelAndDepth);
  out.num_inliers = static_cast<int>(observations.size());
  if (prior) out.prior_information = prior->information;
  if (observations.empty()) return out;

  NormalEquations equations;
  for (int round = 0; round < kRounds; ++round) {
    const bool robust = round < 2;
    const auto linearize = [&](const SE3& T_WC) {
      NormalEquations e = Linearize(camera, T_WC, observations, use, robust);
      if (prior) AddPrior(*prior, T_WC, &e);
      return e;
    };
    double damping = 1e-6;
    equations = linearize(out.T_WC);
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      Matrix6d A = equations.H;
      A.diagonal() *= 1.0 + damping;
      A.diagonal().array() += 1e-9;
      const Vector6d step = -A.ldlt().solve(equations.g);
      if (!step.allFinite()) break;
      const SE3 T_WC_new = out.T_WC * SE3::Exp(step);
      const NormalEquations next = linearize(T_WC_new);
      if (next.cost > equations.cost * (1.0 + 1e-12)) {
        damping *= 100;
        if (damping > 1e6) break;
        continue;
      }
      const bool converged = equations.cost - next.cost < 1e-5 * equations.cost;
      out.T_WC = T_WC_new;
      equations = next;
      damping = std::max(damping * 0.1, 1e-9);
      if (converged) break;
    }

    // Reclassify all observations at the new pose: an outlier may come back.
    const SE3 T_CW = out.T_WC.inverse();
    int changed = 0;
    int num_inliers = 0;
    double chi2_sum = 0;
    int rows_sum = 0;
    Eigen::Vector3d e;
    Eigen::Matrix<double, 3, 6> J;
    for (size_t i = 0; i < observations.size(); ++i) {
      const int rows = ReprojectionResidual(camera, T_CW, observations[i], &e, &J);
      const double w = observations[i].inverse_sigma2;
      const double pixel = w * e.head<2>().squaredNorm();
      const double depth = rows == 3 ? w * e[2] * e[2] : 0;
      uint8_t now = kNotUsed;
      if (rows > 0 && pixel <= kChi2Mono) now = depth <= kChi2Depth ? kPixelAndDepth : kPixelOnly;
      changed += now != use[i];
      use[i] = now;
      out.inlier[i] = now != kNotUsed;
      if (now != kNotUsed) {
        ++num_inliers;
        chi2_sum += pixel;
        rows_sum += 2;
      }
    }
    out.num_inliers = num_inliers;
    out.mean_chi2 = rows_sum > 0 ? chi2_sum / rows_sum : 0;
    if (num_inliers == 0 && !prior) break;
    if (round >= 2 && changed == 0) break;
  }
  out.vision_information = Linearize(camera, out.T_WC, observations, use, false).H;
  return out;
}

}  // namespace gw

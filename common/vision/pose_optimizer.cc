#include "common/vision/pose_optimizer.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "common/core/robust_loss.h"

namespace gw {
namespace {

constexpr int kRounds = 4;
constexpr int kRobustRounds = 2;  // the first ones; then outliers are known and squares are plain
constexpr int kIterations = 10;
constexpr double kConverged = 1e-5;  // relative change of the cost
constexpr double kFirstDamping = 1e-6, kLeastDamping = 1e-9, kMostDamping = 1e6;
constexpr double kSmallestDiagonal = 1e-9;  // keeps the system solvable without observations

// What counts of an observation.
enum Use : uint8_t { kNotUsed = 0, kPixelOnly = 1, kPixelAndDepth = 2 };

struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();  // while rows are added, its lower triangle
  Vector6d g = Vector6d::Zero();
  double cost = 0;
};

template <typename JacobianRows, typename ResidualRows>
void AddRows(const JacobianRows& J, const ResidualRows& r, double limit, bool robust,
             NormalEquations* out) {
  const double chi2 = r.squaredNorm();
  const double weight = robust ? HuberWeight(chi2, limit) : 1.0;
  out->cost += robust ? HuberCost(chi2, limit) : chi2;
  for (int k = 0; k < J.rows(); ++k) {
    for (int i = 0; i < 6; ++i) {
      const double wj = weight * J(k, i);
      for (int m = i; m < 6; ++m) out->H(m, i) += wj * J(k, m);
    }
    out->g += (weight * r[k]) * J.row(k).transpose();
  }
}

void AddPrior(const PosePrior& prior, const SE3& T_WC, NormalEquations* equations) {
  const Vector6d r = (prior.T_WC.inverse() * T_WC).Log();
  const Matrix6d J = RightJacobianInverseSE3(r);
  equations->H += J.transpose() * prior.information * J;
  equations->g += J.transpose() * (prior.information * r);
  equations->cost += r.dot(prior.information * r);
}

class Optimizer {
 public:
  Optimizer(const RectifiedCamera& camera, const std::vector<LandmarkObservation>& observations,
            const std::optional<PosePrior>& prior)
      : camera_(camera),
        observations_(observations),
        prior_(prior),
        use_(observations.size(), kPixelAndDepth) {}

  // Normal equations of the observations in use. robust: Huber's weights, else plain squares.
  NormalEquations OfVision(const SE3& T_WC, bool robust) const {
    NormalEquations out;
    const SE3 T_CW = T_WC.inverse();
    for (size_t i = 0; i < observations_.size(); ++i) {
      if (use_[i] == kNotUsed) continue;
      const PixelObservation& pixel = observations_[i].pixel;
      const Eigen::Vector3d p_C = T_CW * observations_[i].p_W;
      if (!(p_C.z() > kMinProjectionDepth)) {
        out.cost += kChi2Pixel + kChi2Depth;
        continue;
      }
      const Eigen::Vector3d r = ReprojectionResidual(camera_, pixel, p_C);
      const auto J = PoseJacobian(ReprojectionJacobian(camera_, pixel, p_C), p_C);
      AddRows(J.topRows<2>(), r.head<2>(), kChi2Pixel, robust, &out);
      if (pixel.has_depth && use_[i] == kPixelAndDepth) {
        AddRows(J.bottomRows<1>(), r.tail<1>(), kChi2Depth, robust, &out);
      }
    }
    out.H = out.H.selfadjointView<Eigen::Lower>();
    return out;
  }

  // Gauss-Newton with Levenberg's damping, from T_WC.
  SE3 Descend(SE3 T_WC, bool robust) const {
    double damping = kFirstDamping;
    NormalEquations at = Linearize(T_WC, robust);
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      Matrix6d A = at.H;
      A.diagonal() *= 1.0 + damping;
      A.diagonal().array() += kSmallestDiagonal;
      const Vector6d step = -A.ldlt().solve(at.g);
      if (!step.allFinite()) break;
      const SE3 T_WC_next = T_WC * SE3::Exp(step);
      const NormalEquations next = Linearize(T_WC_next, robust);
      if (next.cost > at.cost * (1.0 + 1e-12)) {
        damping *= 100;
        if (damping > kMostDamping) break;
        continue;
      }
      const bool converged = at.cost - next.cost < kConverged * at.cost;
      T_WC = T_WC_next;
      at = next;
      damping = std::max(damping * 0.1, kLeastDamping);
      if (converged) break;
    }
    return T_WC;
  }

  // Decides at this pose what counts of every observation: an outlier may come back. Returns how
  // many it changed.
  int Classify(const SE3& T_WC) {
    const SE3 T_CW = T_WC.inverse();
    int changed = 0;
    for (size_t i = 0; i < observations_.size(); ++i) {
      const Eigen::Vector3d p_C = T_CW * observations_[i].p_W;
      Use now = kNotUsed;
      if (p_C.z() > kMinProjectionDepth) {
        const ObservationFit fit = FitOf(camera_, observations_[i].pixel, p_C);
        if (fit.pixel_ok()) now = fit.depth_ok() ? kPixelAndDepth : kPixelOnly;
      }
      changed += now != use_[i];
      use_[i] = now;
    }
    return changed;
  }

  const std::vector<uint8_t>& use() const { return use_; }

 private:
  NormalEquations Linearize(const SE3& T_WC, bool robust) const {
    NormalEquations out = OfVision(T_WC, robust);
    if (prior_) AddPrior(*prior_, T_WC, &out);
    return out;
  }

  const RectifiedCamera& camera_;
  const std::vector<LandmarkObservation>& observations_;
  const std::optional<PosePrior>& prior_;
  std::vector<uint8_t> use_;  // Use of each observation
};

}  // namespace

PoseEstimate OptimizePose(const RectifiedCamera& camera, const SE3& T_WC_start,
                          const std::vector<LandmarkObservation>& observations,
                          const std::optional<PosePrior>& prior) {
  PoseEstimate out;
  out.T_WC = observations.empty() && prior ? prior->T_WC : T_WC_start;
  if (prior) out.prior_information = prior->information;
  if (observations.empty()) return out;

  Optimizer optimizer(camera, observations, prior);
  for (int round = 0; round < kRounds; ++round) {
    const bool robust = round < kRobustRounds;
    out.T_WC = optimizer.Descend(out.T_WC, robust);
    const int changed = optimizer.Classify(out.T_WC);
    out.num_inliers = static_cast<int>(
        std::count_if(optimizer.use().begin(), optimizer.use().end(), [](uint8_t u) { return u; }));
    if (out.num_inliers == 0 && !prior) break;
    if (!robust && changed == 0) break;
  }
  out.inlier.reserve(observations.size());
  for (const uint8_t use : optimizer.use()) out.inlier.push_back(use != kNotUsed);
  out.vision_information = optimizer.OfVision(out.T_WC, false).H;
  return out;
}

}  // namespace gw

#include "common/vision/pose_optimizer.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>

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

// A row of the Jacobian by the pose, of which column kZero is zero: the others in order.
using RowOfFive = std::array<double, 5>;

template <int kZero>
void AddRow(const RowOfFive& j, double r, double weight, NormalEquations* out) {
  const auto column = [](int k) { return k < kZero ? k : k + 1; };
  for (int i = 0; i < 5; ++i) {
    const double wj = weight * j[i];
    for (int k = i; k < 5; ++k) out->H(column(k), column(i)) += wj * j[k];
    out->g[column(i)] += (weight * r) * j[i];
  }
}

// Rows of PoseJacobian(): with J = d residual / d p_C they are [-J, J [p_C]x], and J(0, 1), J(1, 0)
// and J(2, 1) are zero.
RowOfFive RowU(const Eigen::Matrix3d& J, int row, const Eigen::Vector3d& p) {
  return {-J(row, 0), -J(row, 2), J(row, 2) * -p.y(), J(row, 0) * -p.z() + J(row, 2) * p.x(),
          J(row, 0) * p.y()};
}
RowOfFive RowV(const Eigen::Matrix3d& J, const Eigen::Vector3d& p) {
  return {-J(1, 1), -J(1, 2), J(1, 1) * p.z() + J(1, 2) * -p.y(), J(1, 2) * p.x(),
          J(1, 1) * -p.x()};
}

// What an observation weighs with this chi-square; adds its cost.
double Weigh(double chi2, double limit, bool robust, NormalEquations* out) {
  out->cost += robust ? HuberCost(chi2, limit) : chi2;
  return robust ? HuberWeight(chi2, limit) : 1.0;
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
      const Eigen::Matrix3d J = ReprojectionJacobian(camera_, pixel, p_C);
      const double weight = Weigh(r.head<2>().squaredNorm(), kChi2Pixel, robust, &out);
      AddRow<1>(RowU(J, 0, p_C), r[0], weight, &out);
      AddRow<0>(RowV(J, p_C), r[1], weight, &out);
      if (pixel.has_depth && use_[i] == kPixelAndDepth) {
        AddRow<1>(RowU(J, 2, p_C), r[2], Weigh(r[2] * r[2], kChi2Depth, robust, &out), &out);
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

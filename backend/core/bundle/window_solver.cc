#include "backend/core/bundle/window_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/check.h"
#include "common/core/robust_loss.h"

namespace gw::backend {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Least entry of the diagonal that the damping is a share of: a variable that nothing measures
// stays where it is.
constexpr double kLeastDiagonal = 1e-6;
constexpr double kLeastGain = 1e-3;  // of the decrease that the linear model expects
// Radius of the trust region: the damping is its inverse.
constexpr double kFirstRadius = 1e4;

double Damped(double diagonal, double damping) {
  return diagonal + damping * std::max(diagonal, kLeastDiagonal);
}

// L of H = L L^T, and z = inv(L) b; false when H is not positive definite.
struct Factor3 {
  double l00, l10, l11, l20, l21, l22;  // the diagonal as its inverse

  static bool Of(const Eigen::Matrix3d& H, double damping, Factor3& out) {
    const double d0 = Damped(H(0, 0), damping);
    if (!(d0 > 0)) return false;
    out.l00 = 1 / std::sqrt(d0);
    out.l10 = H(1, 0) * out.l00;
    out.l20 = H(2, 0) * out.l00;
    const double d1 = Damped(H(1, 1), damping) - out.l10 * out.l10;
    if (!(d1 > 0)) return false;
    out.l11 = 1 / std::sqrt(d1);
    out.l21 = (H(2, 1) - out.l20 * out.l10) * out.l11;
    const double d2 = Damped(H(2, 2), damping) - out.l20 * out.l20 - out.l21 * out.l21;
    if (!(d2 > 0)) return false;
    out.l22 = 1 / std::sqrt(d2);
    return true;
  }
  // W inv(L)^T, column by column; for a row vector the same as inv(L) w.
  template <typename Rows>
  Rows Whiten(const Rows& W) const {
    Rows out;
    out.col(0) = W.col(0) * l00;
    out.col(1) = (W.col(1) - out.col(0) * l10) * l11;
    out.col(2) = (W.col(2) - out.col(0) * l20 - out.col(1) * l21) * l22;
    return out;
  }
  // inv(H) b.
  Eigen::Vector3d Solve(const Eigen::Vector3d& b) const {
    const Eigen::Vector3d z = Whiten<Eigen::RowVector3d>(b.transpose()).transpose();
    Eigen::Vector3d x;
    x[2] = z[2] * l22;
    x[1] = (z[1] - l21 * x[2]) * l11;
    x[0] = (z[0] - l10 * x[1] - l20 * x[2]) * l00;
    return x;
  }
};

}  // namespace

int WindowSolver::AddPose(PoseBlock* T_WC, bool fixed) {
  GW_CHECK(columns_ == 6 * free_poses_);
  blocks_.push_back({T_WC->data(), 7, 6, fixed ? -1 : columns_});
  if (!fixed) {
    columns_ += 6;
    ++free_poses_;
  }
  return static_cast<int>(blocks_.size()) - 1;
}

int WindowSolver::AddVariable(double* values, int size) {
  blocks_.push_back({values, size, size, columns_});
  columns_ += size;
  return static_cast<int>(blocks_.size()) - 1;
}

void WindowSolver::AddCost(const ceres::CostFunction* cost, const ceres::LossFunction* loss,
                           std::vector<int> blocks) {
  costs_.push_back({cost, loss, std::move(blocks)});
}

void WindowSolver::AddLandmark(Eigen::Vector3d* p_W, std::span<const Sight> sights) {
  const size_t begin = sights_.size();
  sights_.insert(sights_.end(), sights.begin(), sights.end());
  landmarks_.push_back({p_W, begin, sights_.size()});
}

std::vector<WindowSolver::Camera> WindowSolver::Cameras() const {
  std::vector<Camera> out;
  out.reserve(blocks_.size());
  for (const Block& block : blocks_) {
    if (block.ambient != 7) break;
    const SE3 T_WC = FromBlock(block.values);
    out.push_back({T_WC.rotation().toRotationMatrix().transpose(), T_WC.translation()});
  }
  return out;
}

// Infinity where a landmark is not in front of a camera.
double WindowSolver::CostOfSights() const {
  const std::vector<Camera> cameras = Cameras();
  double sum = 0;
  for (const Landmark& landmark : landmarks_) {
    for (size_t i = landmark.begin; i < landmark.end; ++i) {
      const Sight& sight = sights_[i];
      const Camera& camera = cameras[sight.pose];
      const Eigen::Vector3d p_C = camera.R_CW * (*landmark.p_W - camera.p_WC);
      if (!(p_C.z() > kMinProjectionDepth)) return kInfinity;
      const ObservationFit fit = FitOf(camera_, sight.pixel, p_C);
      sum += HuberCost(fit.chi2_pixel, kChi2Pixel) + HuberCost(fit.chi2_depth, kChi2Depth);
    }
  }
  return 0.5 * sum;
}

double WindowSolver::CostOfCosts() const {
  double sum = 0;
  std::vector<const double*> parameters;
  Eigen::VectorXd r;
  for (const Cost& cost : costs_) {
    parameters.clear();
    for (const int block : cost.blocks) parameters.push_back(blocks_[block].values);
    r.resize(cost.function->num_residuals());
    if (!cost.function->Evaluate(parameters.data(), r.data(), nullptr)) return kInfinity;
    double rho[3] = {r.squaredNorm(), 1, 0};
    if (cost.loss != nullptr) cost.loss->Evaluate(rho[0], rho);
    sum += rho[0];
  }
  return 0.5 * sum;
}

// With p_C = R_CW (p_W - p_WC), J = d residual / d p_C, weights w and X = [p_C]x, the Jacobians are
// J R_CW for the landmark and J [-I, X] for the pose. All blocks follow from A = J^T w J.
void WindowSolver::LinearizeSights() {
  const std::vector<Camera> cameras = Cameras();
  for (size_t l = 0; l < landmarks_.size(); ++l) {
    const Landmark& landmark = landmarks_[l];
    Point& point = points_[l];
    point.H.setZero();
    point.b.setZero();
    for (size_t i = landmark.begin; i < landmark.end; ++i) {
      const Sight& sight = sights_[i];
      const Camera& camera = cameras[sight.pose];
      const Eigen::Vector3d p_C = camera.R_CW * (*landmark.p_W - camera.p_WC);
      const Eigen::Vector3d r = ReprojectionResidual(camera_, sight.pixel, p_C);
      const Eigen::Matrix3d J = ReprojectionJacobian(camera_, sight.pixel, p_C);
      const double w = HuberWeight(r.head<2>().squaredNorm(), kChi2Pixel);
      const Eigen::Vector3d weight(w, w, HuberWeight(r[2] * r[2], kChi2Depth));
      const Eigen::Matrix3d Jw = weight.asDiagonal() * J;
      const Eigen::Matrix3d A = J.transpose() * Jw;
      const Eigen::Vector3d a = Jw.transpose() * r;
      const Eigen::Matrix3d B = A * camera.R_CW;
      point.H.noalias() += camera.R_CW.transpose() * B;
      point.b.noalias() -= camera.R_CW.transpose() * a;
      const int column = blocks_[sight.pose].column;
      if (column < 0) continue;
      const Eigen::Matrix3d X = Skew(p_C);
      const Eigen::Matrix3d AX = A * X;
      couplings_[i].topRows<3>() = -B;
      couplings_[i].bottomRows<3>().noalias() = X.transpose() * B;
      auto H = H_.block<6, 6>(column, column);
      H.topLeftCorner<3, 3>() += A;
      H.bottomLeftCorner<3, 3>() -= AX.transpose();
      H.bottomRightCorner<3, 3>().noalias() += X.transpose() * AX;
      b_.segment<3>(column) += a;
      b_.segment<3>(column + 3).noalias() -= X.transpose() * a;
    }
  }
}

void WindowSolver::LinearizeCost(const Cost& cost) {
  const int rows = cost.function->num_residuals();
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<const double*> parameters;
  std::vector<RowMajor> ambient;
  std::vector<double*> out;
  parameters.reserve(cost.blocks.size());
  ambient.reserve(cost.blocks.size());
  out.reserve(cost.blocks.size());
  for (const int block : cost.blocks) {
    parameters.push_back(blocks_[block].values);
    ambient.emplace_back(rows, blocks_[block].ambient);
  }
  for (RowMajor& J : ambient) out.push_back(J.data());
  Eigen::VectorXd r(rows);
  GW_CHECK(cost.function->Evaluate(parameters.data(), r.data(), out.data()));
  double rho[3] = {0, 1, 0};
  if (cost.loss != nullptr) cost.loss->Evaluate(r.squaredNorm(), rho);
  std::vector<Eigen::MatrixXd> J;
  for (size_t i = 0; i < cost.blocks.size(); ++i) {
    const Block& block = blocks_[cost.blocks[i]];
    J.push_back(ambient[i]);
    if (block.ambient != 7) continue;
    Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
    PoseManifold().PlusJacobian(block.values, plus.data());
    J.back() = ambient[i] * plus;
  }
  for (size_t i = 0; i < cost.blocks.size(); ++i) {
    const Block& a = blocks_[cost.blocks[i]];
    if (a.column < 0) continue;
    b_.segment(a.column, a.tangent) -= rho[1] * J[i].transpose() * r;
    for (size_t k = 0; k < cost.blocks.size(); ++k) {
      const Block& b = blocks_[cost.blocks[k]];
      if (b.column < 0 || b.column > a.column) continue;
      H_.block(a.column, b.column, a.tangent, b.tangent) += rho[1] * J[i].transpose() * J[k];
    }
  }
}

void WindowSolver::Linearize() {
  H_.setZero(columns_, columns_);
  b_.setZero(columns_);
  points_.resize(landmarks_.size());
  couplings_.resize(sights_.size());
  LinearizeSights();
  for (const Cost& cost : costs_) LinearizeCost(cost);
}

// A landmark whose damped block is not positive definite stays where it is.
void WindowSolver::Eliminate(double damping) {
  eliminated_.assign(static_cast<size_t>(free_poses_ * (free_poses_ + 1) / 2), Matrix6d::Zero());
  reduced_b_ = b_;
  std::vector<std::pair<size_t, Coupling>> whitened;  // free poses that see the landmark
  for (size_t l = 0; l < landmarks_.size(); ++l) {
    Factor3 factor;
    if (!Factor3::Of(points_[l].H, damping, factor)) continue;
    const Eigen::RowVector3d z = factor.Whiten<Eigen::RowVector3d>(points_[l].b.transpose());
    whitened.clear();
    for (size_t i = landmarks_[l].begin; i < landmarks_[l].end; ++i) {
      const int column = blocks_[sights_[i].pose].column;
      if (column < 0) continue;
      whitened.emplace_back(column / 6, factor.Whiten<Coupling>(couplings_[i]));
      const Coupling& W = whitened.back().second;
      reduced_b_.segment<6>(column).noalias() -= W * z.transpose();
      const size_t row = static_cast<size_t>(column / 6);
      for (const auto& [other, W_other] : whitened) {
        eliminated_[row * (row + 1) / 2 + other].noalias() += W * W_other.transpose();
      }
    }
  }
  reduced_ = H_;
  for (int a = 0, k = 0; a < free_poses_; ++a) {
    for (int b = 0; b <= a; ++b, ++k) {
      reduced_.block<6, 6>(6 * a, 6 * b) -= eliminated_[static_cast<size_t>(k)];
    }
  }
  for (int i = 0; i < columns_; ++i) {
    reduced_(i, i) += damping * std::max(H_(i, i), kLeastDiagonal);
  }
}

bool WindowSolver::SolveReduced() {
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> factor(reduced_);
  if (factor.info() != Eigen::Success) return false;
  step_ = factor.solve(reduced_b_);
  return step_.allFinite();
}

// With (H + D) d = b the model decreases by (b d + d D d) / 2.
double WindowSolver::BackSubstitute(double damping) {
  double twice = 0;
  for (int i = 0; i < columns_; ++i) {
    twice += step_[i] * (b_[i] + damping * std::max(H_(i, i), kLeastDiagonal) * step_[i]);
  }
  point_steps_.resize(landmarks_.size());
  for (size_t l = 0; l < landmarks_.size(); ++l) {
    Eigen::Vector3d& d = point_steps_[l];
    Factor3 factor;
    if (!Factor3::Of(points_[l].H, damping, factor)) {
      d.setZero();
      continue;
    }
    Eigen::Vector3d b = points_[l].b;
    for (size_t i = landmarks_[l].begin; i < landmarks_[l].end; ++i) {
      const int column = blocks_[sights_[i].pose].column;
      if (column >= 0) b.noalias() -= couplings_[i].transpose() * step_.segment<6>(column);
    }
    d = factor.Solve(b);
    for (int i = 0; i < 3; ++i) {
      const double diagonal = std::max(points_[l].H(i, i), kLeastDiagonal);
      twice += d[i] * (points_[l].b[i] + damping * diagonal * d[i]);
    }
  }
  return 0.5 * twice;
}

void WindowSolver::Move() {
  for (const Block& block : blocks_) {
    if (block.column < 0) continue;
    if (block.ambient == 7) {
      PoseBlock moved;
      PoseManifold().Plus(block.values, step_.data() + block.column, moved.data());
      std::copy(moved.begin(), moved.end(), block.values);
    } else {
      for (int i = 0; i < block.tangent; ++i) block.values[i] += step_[block.column + i];
    }
  }
  for (size_t l = 0; l < landmarks_.size(); ++l) *landmarks_[l].p_W += point_steps_[l];
}

void WindowSolver::Save() {
  saved_.clear();
  for (const Block& block : blocks_) {
    saved_.insert(saved_.end(), block.values, block.values + block.ambient);
  }
  for (const Landmark& landmark : landmarks_) {
    saved_.insert(saved_.end(), landmark.p_W->data(), landmark.p_W->data() + 3);
  }
}

void WindowSolver::Restore() {
  const double* at = saved_.data();
  for (const Block& block : blocks_) {
    std::copy(at, at + block.ambient, block.values);
    at += block.ambient;
  }
  for (const Landmark& landmark : landmarks_) {
    *landmark.p_W = Eigen::Map<const Eigen::Vector3d>(at);
    at += 3;
  }
}

WindowSolver::Summary WindowSolver::Solve(const Options& options) {
  Summary out;
  double cost = TotalCost();
  if (!std::isfinite(cost)) return out;
  out.usable = true;
  double radius = kFirstRadius;
  double shrink = 2;
  bool moved = true;
  Save();
  while (out.iterations < options.iterations) {
    if (options.stop && options.stop()) {
      out.usable = false;
      return out;
    }
    if (moved) Linearize();
    ++out.iterations;
    Eliminate(1 / radius);
    double expected = 0;
    double next_cost = kInfinity;
    if (SolveReduced()) {
      expected = BackSubstitute(1 / radius);
      Move();
      next_cost = TotalCost();
    }
    const double decrease = cost - next_cost;
    const double gain = decrease / expected;
    const bool converged = std::abs(decrease) <= options.function_tolerance * cost;
    moved = gain > kLeastGain;  // false for NaN
    if (moved) {
      cost = next_cost;
      Save();
      radius /= std::max(1.0 / 3, 1 - std::pow(2 * gain - 1, 3));
      shrink = 2;
    } else {
      Restore();
      radius /= shrink;
      shrink *= 2;
    }
    if (converged) break;
  }
  return out;
}

}  // namespace gw::backend

#include "frontend/core/features/eye_sync.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace gw::frontend {
namespace {

constexpr double kMemory = 10;        // s
constexpr double kTypicalDepth = 3;   // m, of features without
constexpr double kCertain = 5;        // sigmas
constexpr double kLeastSigma = 0.5;   // px of a row offset: features lie on a grid of pixels
constexpr double kTooFar = 3;         // sigmas from where a row offset counts no more than there
constexpr double kPriorLateness = 1;  // s
constexpr double kPriorRow = 3;       // px, px per unit of the image plane
constexpr double kPixel = 1;          // px: sigma of a disparity

}  // namespace

Eigen::Matrix4d EyeSync::WithPrior() const {
  const Vector4 sigma(kPriorLateness, kPriorRow, kPriorRow, kPriorRow);
  Eigen::Matrix4d out = information_;
  out.diagonal() += sigma.cwiseAbs2().cwiseInverse();
  return out;
}

Eigen::Vector2d EyeSync::SpeedOf(const Feature& f, const Vector6d& twist) const {
  const Eigen::Vector3d p = camera_.Unproject(f.u, f.v, f.has_depth() ? f.depth : kTypicalDepth);
  const Eigen::Vector3d dp = -twist.head<3>() - twist.tail<3>().cross(p);
  return {camera_.fx * (dp.x() - p.x() / p.z() * dp.z()) / p.z(),
          camera_.fy * (dp.y() - p.y() / p.z() * dp.z()) / p.z()};
}

void EyeSync::Observe(const FeatureFrame& frame, const SE3& T_ab, DurationUs dt) {
  const double kept = std::exp(-dt.seconds() / kMemory);
  information_ *= kept;
  vector_ *= kept;
  squares_ *= kept;
  count_ *= kept;
  const Vector6d twist = T_ab.Log() / dt.seconds();
  const Vector4 x = WithPrior().ldlt().solve(vector_);
  const double sigma = std::max(kLeastSigma, std::sqrt(squares_ / std::max(count_, 1.0)));
  for (const FeatureFrame::RowOffset& o : frame.row_offsets) {
    const Feature& f = frame.features[static_cast<size_t>(o.feature)];
    Vector4 row;
    row << SpeedOf(f, twist).y(), 1, (f.v - camera_.cy) / camera_.fy,
        (f.u - camera_.cx) / camera_.fx;
    const double residual = o.dv - row.dot(x);
    const double weight = std::min(1.0, kTooFar * sigma / std::max(std::abs(residual), 1e-9));
    information_ += weight / (sigma * sigma) * row * row.transpose();
    vector_ += weight / (sigma * sigma) * row * o.dv;
    squares_ += weight * residual * residual;
    count_ += weight;
  }
}

double EyeSync::Lateness() const {
  const Eigen::LDLT<Eigen::Matrix4d> solver(WithPrior());
  const double tau = solver.solve(vector_)[0];
  const double variance = solver.solve(Vector4::Unit(0))[0];
  return tau * tau > kCertain * kCertain * variance ? tau : 0;
}

bool EyeSync::SpoilsDepth(const FeatureFrame& frame, const SE3& T_ab, DurationUs dt) const {
  const double late = Lateness();
  if (late == 0 || frame.features.empty()) return false;
  const Vector6d twist = T_ab.Log() / dt.seconds();
  double sum = 0;
  for (const Feature& f : frame.features) {
    const double du = late * SpeedOf(f, twist).x();
    sum += du * du;
  }
  return sum > kPixel * kPixel * static_cast<double>(frame.features.size());
}

}  // namespace gw::frontend

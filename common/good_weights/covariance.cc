#include "common/good_weights/covariance.h"

#include <cmath>
#include <numbers>

#include "common/core/covariance.h"

namespace gw {
namespace {

constexpr int kHeldByFloor[] = {2, 3, 4};  // height, roll, pitch of the body

}  // namespace

Matrix6d NominalCovariance(DurationUs interval, const DrWeightConfig& config) {
  const double frames = 30.0 * interval.seconds();
  const double sigma_t = config.sigma_trans_m_per_frame;
  const double sigma_r = config.sigma_rot_deg_per_frame * std::numbers::pi / 180.0;
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(sigma_t * sigma_t),
      Eigen::Vector3d::Constant(sigma_r * sigma_r);
  return (frames * variance).asDiagonal();
}

Matrix6d DrCovariance(DurationUs interval, const Matrix6d& reported, const DrWeightConfig& config) {
  Matrix6d nominal = NominalCovariance(interval, config);
  if (!config.Departs(Departure::kReportedNoise)) return nominal;
  if (config.Departs(Departure::kFloor)) {
    for (const int i : kHeldByFloor) {
      if (reported(i, i) > 0) nominal(i, i) = reported(i, i);
    }
  }
  return LargerCovariance(nominal, reported);
}

Matrix6d ScaledCovariance(const Matrix6d& cov, const DrScale& alpha, const Matrix6d& honest) {
  Vector6d root;
  root << Eigen::Vector3d::Constant(1 / std::sqrt(alpha.translation)),
      Eigen::Vector3d::Constant(1 / std::sqrt(alpha.rotation));
  const Matrix6d scaled = root.asDiagonal() * cov * root.asDiagonal();
  return honest.isZero(0) ? scaled : LargerCovariance(scaled, honest);
}

DrScale EffectiveScale(const Matrix6d& cov, const Matrix6d& scaled) {
  const auto of_block = [&](int i) {
    const Eigen::Matrix3d before = cov.block<3, 3>(i, i);
    const Eigen::Matrix3d after = scaled.block<3, 3>(i, i);
    return 3 / before.llt().solve(after).trace();
  };
  return {of_block(0), of_block(3)};
}

}  // namespace gw

#include "frontend/core/place/recovery.h"

#include <Eigen/Cholesky>

namespace gw::frontend {

Matrix6d CovarianceOfNoIdea() {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(100), Eigen::Vector3d::Constant(1);
  return variance.asDiagonal();
}

bool PosesAgree(const SE3& T_expected, const SE3& T_found, const Matrix6d& cov) {
  const Vector6d d = (T_expected.inverse() * T_found).Log();
  return d.dot(Eigen::LDLT<Matrix6d>(cov).solve(d)) <= kChi2Six99;
}

Recovery::Verdict Recovery::Judge(const Finding& found,
                                  const std::optional<Expectation>& expected) {
  const bool many = found.num_inliers >= kConvincingInliers;
  const bool again = before_ && PosesAgree(before_->T_WC * found.T_ab, found.T_WC,
                                           before_->cov + found.cov_ab + found.cov);
  const int images = again ? before_->images + 1 : 1;
  before_ = Streak{found.T_WC, found.cov, images};
  if (expected && PosesAgree(expected->T_WC, found.T_WC, expected->cov + found.cov)) {
    const bool enough = many || (again && !expected->in_doubt);
    return enough ? Verdict::kAsExpected : Verdict::kWait;
  }
  return many && images >= kContradictingImages ? Verdict::kElsewhere : Verdict::kWait;
}

}  // namespace gw::frontend

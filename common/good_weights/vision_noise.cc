#include "common/good_weights/vision_noise.h"

#include <Eigen/Cholesky>

namespace gw {

Vector6d VisionInflation() {
  Vector6d scale;
  scale << 1.85, 1.2, 2.8, 0.95, 1.55, 0.9;
  return scale;
}

Matrix6d Inflated(const Matrix6d& cov) {
  const Vector6d scale = VisionInflation();
  return scale.asDiagonal() * (0.5 * (cov + cov.transpose())) * scale.asDiagonal();
}

Matrix6d VisionCovariance(const Matrix6d& vision_information) {
  return Inflated(vision_information.ldlt().solve(Matrix6d::Identity()));
}

}  // namespace gw

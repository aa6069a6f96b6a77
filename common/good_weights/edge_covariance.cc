#include "common/good_weights/edge_covariance.h"

#include <Eigen/LU>
#include <algorithm>

#include "common/good_weights/covariance.h"
#include "common/good_weights/vision_noise.h"

namespace gw {

Matrix6d EdgeCovariance(const DrMotion& motion, double alpha, Variant variant,
                        const DrWeightConfig& config) {
  const bool bounded = AdaptsAlpha(variant) && config.Departs(Departure::kBound);
  const Matrix6d honest = bounded ? motion.reported_cov : Matrix6d::Zero();
  return ScaledCovariance(motion.cov, {alpha, alpha}, honest);
}

Matrix6d LoopEdgeCovariance(const DrMotion& motion, double alpha, Variant variant,
                            const DrWeightConfig& config) {
  return EdgeCovariance(motion, std::min(alpha, 1.0), variant, config);
}

Matrix6d WholeMapEdgeCovariance(const DrMotion& motion, double alpha, Variant variant,
                                const DrWeightConfig& config) {
  const Matrix6d local = EdgeCovariance(motion, alpha, variant, config);
  const bool knows_way = AdaptsAlpha(variant) && config.Departs(Departure::kWay);
  if (!knows_way || motion.reported_cov.isZero(0)) return local;
  const Matrix6d known = EdgeCovariance(motion, config.alpha_max, variant, config);
  const double inflation = VisionInflation().head<3>().squaredNorm() / 3;
  Matrix6d information = local.inverse();
  information.topLeftCorner<3, 3>() += inflation * known.topLeftCorner<3, 3>().inverse();
  return information.inverse();
}

}  // namespace gw

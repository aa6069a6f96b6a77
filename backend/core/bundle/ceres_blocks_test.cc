#include "backend/core/bundle/ceres_blocks.h"

#include <ceres/manifold_test_utils.h>
#include <gtest/gtest.h>

#include "backend/test/world.h"
#include "common/core/random.h"

namespace gw::backend {
namespace {

Vector6d RandomTangent(CounterRng& rng, double scale) {
  Vector6d out;
  for (int i = 0; i < 6; ++i) out[i] = scale * rng.Uniform(-1, 1);
  return out;
}

TEST(PoseManifold, IsAManifold) {
  using namespace ceres;  // the macro below names the matchers without it
  const PoseManifold manifold;
  for (uint64_t seed = 0; seed < 200; ++seed) {
    CounterRng rng(seed, 1, 0);
    const PoseBlock x_block = ToBlock(SE3::Exp(RandomTangent(rng, 2.0)));
    // Less than half a turn away: q and -q are the same rotation, but not the same block.
    const PoseBlock y_block =
        ToBlock(FromBlock(x_block.data()) * SE3::Exp(RandomTangent(rng, 1.5)));
    const ceres::Vector x = Eigen::Map<const Eigen::Matrix<double, 7, 1>>(x_block.data());
    const ceres::Vector y = Eigen::Map<const Eigen::Matrix<double, 7, 1>>(y_block.data());
    const ceres::Vector delta = RandomTangent(rng, 1.0);
    EXPECT_THAT_MANIFOLD_INVARIANTS_HOLD(manifold, x, delta, y, 1e-9);
  }
}

TEST(PoseManifold, PlusIsOurRightPerturbation) {
  CounterRng rng(7, 1, 0);
  const SE3 T = SE3::Exp(RandomTangent(rng, 1.0));
  const Vector6d d = RandomTangent(rng, 0.3);
  const PoseBlock x = ToBlock(T);
  PoseBlock plus;
  PoseManifold().Plus(x.data(), d.data(), plus.data());
  EXPECT_LT((FromBlock(plus.data()).matrix() - (T * SE3::Exp(d)).matrix()).norm(), 1e-12);
}

// Jacobian of a cost with respect to the tangent of one of its blocks (a pose or a point).
Eigen::MatrixXd AnalyticJacobian(const ceres::CostFunction& cost,
                                 const std::vector<const double*>& blocks, size_t which) {
  const int rows = cost.num_residuals();
  const int columns = cost.parameter_block_sizes()[which];
  Eigen::Matrix<double, -1, -1, Eigen::RowMajor> J(rows, columns);
  std::vector<double*> jacobians(blocks.size(), nullptr);
  jacobians[which] = J.data();
  Eigen::VectorXd r(rows);
  EXPECT_TRUE(cost.Evaluate(blocks.data(), r.data(), jacobians.data()));
  if (columns != 7) return J;
  Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
  PoseManifold().PlusJacobian(blocks[which], plus.data());
  return J * plus;
}

Eigen::MatrixXd NumericJacobian(const ceres::CostFunction& cost, std::vector<const double*> blocks,
                                size_t which) {
  const int size = cost.parameter_block_sizes()[which];
  const bool is_pose = size == 7;
  const double* const at = blocks[which];
  Eigen::MatrixXd J(cost.num_residuals(), is_pose ? 6 : size);
  for (int i = 0; i < J.cols(); ++i) {
    Eigen::VectorXd r[2] = {Eigen::VectorXd(J.rows()), Eigen::VectorXd(J.rows())};
    for (const int side : {0, 1}) {
      Vector6d d = Vector6d::Zero();
      d[i] = side == 0 ? -1e-6 : 1e-6;
      double moved[7];
      if (is_pose) {
        PoseManifold().Plus(at, d.data(), moved);
      } else {
        for (int k = 0; k < size; ++k) moved[k] = at[k] + d[k];
      }
      blocks[which] = moved;
      EXPECT_TRUE(cost.Evaluate(blocks.data(), r[side].data(), nullptr));
    }
    J.col(i) = (r[1] - r[0]) / 2e-6;
  }
  return J;
}

void ExpectJacobiansMatch(const ceres::CostFunction& cost,
                          const std::vector<const double*>& blocks) {
  for (size_t which = 0; which < blocks.size(); ++which) {
    const Eigen::MatrixXd numeric = NumericJacobian(cost, blocks, which);
    const Eigen::MatrixXd analytic = AnalyticJacobian(cost, blocks, which);
    EXPECT_LT((numeric - analytic).norm(), 1e-6 * (1 + numeric.norm())) << "block " << which;
  }
}

TEST(ReprojectionCost, JacobiansMatchCentralDifferences) {
  const RectifiedCamera camera = TestCamera();
  for (uint64_t seed = 0; seed < 200; ++seed) {
    CounterRng rng(seed, 2, 0);
    const SE3 T_WC = SE3::Exp(RandomTangent(rng, 2.0));
    const Eigen::Vector3d p_C(rng.Uniform(-2, 2), rng.Uniform(-1, 1), rng.Uniform(0.5, 6));
    const Eigen::Vector3d p_W = T_WC * p_C;
    const PoseBlock pose = ToBlock(T_WC);
    const PixelObservation pixel{300, 200, 20, true, 0.6, 0.4};
    ExpectJacobiansMatch(ReprojectionCost<3>(&camera, pixel), {pose.data(), p_W.data()});
    ExpectJacobiansMatch(ReprojectionCost<2>(&camera, pixel), {pose.data(), p_W.data()});
  }
}

TEST(ReprojectionCost, RefusesAPointBehindTheCamera) {
  const RectifiedCamera camera = TestCamera();
  const PoseBlock pose = ToBlock(SE3());
  const Eigen::Vector3d behind(0, 0, -1);
  const double* blocks[] = {pose.data(), behind.data()};
  double residuals[3];
  EXPECT_FALSE(ReprojectionCost<3>(&camera, {}).Evaluate(blocks, residuals, nullptr));
}

// Two poses, and a measured motion between them that they do not quite fit.
struct RandomEdge {
  explicit RandomEdge(CounterRng& rng) {
    a = ToBlock(SE3::Exp(RandomTangent(rng, 2.0)));
    T_ab = SE3::Exp(RandomTangent(rng, 1.0));
    b = ToBlock(FromBlock(a.data()) * T_ab * SE3::Exp(RandomTangent(rng, 0.3)));
    for (int i = 0; i < 6; ++i) sqrt_information(0, i) += rng.Uniform(-1, 1);
  }
  PoseBlock a{}, b{};
  SE3 T_ab;
  Matrix6d sqrt_information = Matrix6d::Identity();
};

TEST(RelativePoseCost, JacobiansMatchCentralDifferences) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    CounterRng rng(seed, 3, 0);
    const RandomEdge e(rng);
    ExpectJacobiansMatch(RelativePoseCost(e.T_ab, e.sqrt_information), {e.a.data(), e.b.data()});
  }
}

TEST(ScaledMotionCost, JacobiansMatchCentralDifferences) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    CounterRng rng(seed, 4, 0);
    const RandomEdge e(rng);
    ScaleLever lever;
    for (int i = 0; i < 12; ++i) lever(i % 6, i / 6) = rng.Uniform(-1, 1);
    const Eigen::Vector2d errors(rng.Uniform(-0.1, 0.1), rng.Uniform(-0.1, 0.1));
    ExpectJacobiansMatch(ScaledMotionCost(e.T_ab, lever, e.sqrt_information),
                         {e.a.data(), e.b.data(), errors.data()});
  }
}

TEST(HeightCost, JacobiansMatchCentralDifferences) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    CounterRng rng(seed, 6, 0);
    const SE3 T_BC = SE3::Exp(RandomTangent(rng, 2));
    const PoseBlock T_WC = ToBlock(SE3::Exp(RandomTangent(rng, 2)));
    ExpectJacobiansMatch(HeightCost(T_BC, rng.Uniform(-1, 1), 0.1), {T_WC.data()});
  }
}

TEST(ScalePrior, JacobiansMatchCentralDifferences) {
  const Eigen::Vector2d errors(0.02, -0.01);
  const ScalePrior prior(0.01);
  ExpectJacobiansMatch(prior, {errors.data()});
  const double* const blocks[] = {errors.data()};
  Eigen::Vector2d residual;
  ASSERT_TRUE(prior.Evaluate(blocks, residual.data(), nullptr));
  EXPECT_LT((residual - Eigen::Vector2d(2, -1)).norm(), 1e-12);
}

}  // namespace
}  // namespace gw::backend

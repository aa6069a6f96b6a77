#include "common/good_weights/edge_covariance.h"

#include <gtest/gtest.h>

#include <numbers>

#include "common/core/covariance.h"
#include "common/core/random.h"
#include "common/good_weights/covariance.h"
#include "common/good_weights/vision_noise.h"

namespace gw {
namespace {

// T_BC of a camera that looks forward and a little down, 0.35 m above the floor.
const SE3 kCamera(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5) * ExpSO3({0.05, 0, 0}),
                  {0.1, 0.02, 0.35});

TEST(CameraMotion, IsTheBodysMotionSeenFromTheCamera) {
  const SE3 T_WBa(ExpSO3({0.1, 0.2, 0.3}), {1, 2, 3});
  const SE3 T_WBb(ExpSO3({-0.1, 0.1, 0.5}), {1.3, 2.1, 3});
  DrIncrement dr;
  dr.utime_end = Utime{1'000'000};
  dr.T_BaBb = T_WBa.inverse() * T_WBb;
  const DrMotion motion = CameraMotion(dr, kCamera, {});
  const SE3 expected = (T_WBa * kCamera).inverse() * (T_WBb * kCamera);
  EXPECT_LT((motion.T_CaCb.matrix() - expected.matrix()).norm(), 1e-12);
}

TEST(CameraMotion, TellsWhatErrorsOfTheScalesOfWayAndTurnDo) {
  DrIncrement dr;
  dr.utime_end = Utime{1'000'000};
  dr.T_BaBb = SE3(ExpSO3({0.02, -0.01, 0.4}), {0.3, 0.1, 0.01});
  const DrMotion motion = CameraMotion(dr, kCamera, {});
  const Eigen::Vector2d errors(0.01, -0.008);
  const SE3 longer(ExpSO3((1 + errors[1]) * LogSO3(dr.T_BaBb.rotation())),
                   (1 + errors[0]) * dr.T_BaBb.translation());
  const SE3 expected = kCamera.inverse() * longer * kCamera;
  const SE3 told = motion.T_CaCb * SE3::Exp(motion.lever * errors);
  EXPECT_LT((told.inverse() * expected).Log().norm(), 1e-4);
  EXPECT_GT((motion.T_CaCb.inverse() * expected).Log().norm(), 3e-3);
}

TEST(CameraMotion, NominalCovarianceGrowsWithTheNumberOfFramePeriods) {
  DrIncrement dr;  // the filter claims to know it exactly
  dr.utime_end = Utime{500'000};
  const Matrix6d cov = CameraMotion(dr, SE3(), {}).cov;
  EXPECT_NEAR(cov(0, 0), 15 * 0.004 * 0.004, 1e-12);
  EXPECT_NEAR(cov(5, 5), 15 * std::pow(0.1 * std::numbers::pi / 180, 2), 1e-12);
  const Matrix6d in_camera = InCamera(cov, kCamera);
  EXPECT_LT((CameraMotion(dr, kCamera, {}).cov - in_camera).norm(), 1e-12);
}

// Sigmas of a filter that knows the way to a hundredth of what is nominal, and the like.
Matrix6d Reported(CounterRng* random) {
  Vector6d sigma;
  for (int i = 0; i < 6; ++i) sigma[i] = (i < 3 ? 4e-3 : 1.7e-3) * random->Uniform(0.01, 0.5);
  const Eigen::Quaterniond turn =
      ExpSO3({0.3 * random->Normal(), 0.3 * random->Normal(), 0.3 * random->Normal()});
  Matrix6d mix = Matrix6d::Identity();
  mix.topLeftCorner<3, 3>() = mix.bottomRightCorner<3, 3>() = turn.toRotationMatrix();
  return mix * Matrix6d(sigma.cwiseAbs2().asDiagonal()) * mix.transpose();
}

TEST(DrCovariance, WhatTheFloorHoldsIsKnownAsReportedTheRestNoBetterThanNominal) {
  CounterRng random(1, 0, 0);
  for (int k = 0; k < 50; ++k) {
    const Matrix6d reported = Reported(&random);
    const Matrix6d nominal = NominalCovariance(Milliseconds(100), {});
    const Matrix6d cov = DrCovariance(Milliseconds(100), reported, {});
    for (const int i : {0, 1, 5}) EXPECT_GE(cov(i, i), nominal(i, i) * (1 - 1e-9)) << i;
    for (const int i : {2, 3, 4}) {
      EXPECT_GE(cov(i, i), reported(i, i) * (1 - 1e-9)) << i;
      EXPECT_LT(cov(i, i), 3 * reported(i, i)) << i;
    }
  }
}

TEST(DrCovariance, IsNominalInAllWhereTheFloorIsNoDepartureOrNothingIsReported) {
  CounterRng random(2, 0, 0);
  const Matrix6d nominal = NominalCovariance(Milliseconds(100), {});
  DrWeightConfig flying;
  flying.changed.Insert(Departure::kFloor);
  const Matrix6d cov = DrCovariance(Milliseconds(100), 1e-3 * Reported(&random), flying);
  EXPECT_LT((cov - nominal).norm(), 1e-9 * nominal.norm());
  const Matrix6d of_nothing = DrCovariance(Milliseconds(100), Matrix6d::Zero(), {});
  EXPECT_LT((of_nothing - nominal).norm(), 1e-9 * nominal.norm());
}

// The filter's covariance is moved to the camera by sampling, independent of the adjoint.
TEST(CameraMotion, CarriesTheFiltersCovarianceToTheCamera) {
  DrIncrement dr;
  dr.utime_end = Utime{33'333};
  dr.T_BaBb = SE3(ExpSO3({0, 0, 0.2}), {0.3, 0, 0});
  Vector6d sigma;
  sigma << 0.05, 0.04, 0.06, 0.05, 0.04, 0.1;
  dr.cov = sigma.cwiseAbs2().asDiagonal();
  const DrMotion motion = CameraMotion(dr, kCamera, {});
  Matrix6d sampled = Matrix6d::Zero();
  constexpr int kSamples = 20000;
  for (uint64_t i = 0; i < kSamples; ++i) {
    CounterRng rng(3, 4, i);
    Vector6d d;
    for (int k = 0; k < 6; ++k) d[k] = 0.1 * sigma[k] * rng.Normal();  // small: stays linear
    const SE3 T = kCamera.inverse() * dr.T_BaBb * SE3::Exp(d) * kCamera;
    const Vector6d e = (motion.T_CaCb.inverse() * T).Log();
    sampled += e * e.transpose() * 100.0 / kSamples;
  }
  EXPECT_LT((sampled - motion.cov).norm(), 0.05 * motion.cov.norm());
}

DrMotion ForwardMotion(double reported_sigma_m) {
  DrIncrement dr;
  dr.utime_end = Utime{500'000};
  dr.T_BaBb = SE3(ExpSO3({0, 0, 0.2}), {0.3, 0, 0});
  dr.cov.setZero();
  dr.cov.diagonal().setConstant(reported_sigma_m * reported_sigma_m);
  return CameraMotion(dr, kCamera, {});
}

TEST(EdgeCovariance, ScalesTheNominalNoise) {
  const DrMotion sure = ForwardMotion(1e-9);
  for (const double alpha : {0.1, 1.0, 1000.0}) {
    EXPECT_LT((EdgeCovariance(sure, alpha, Variant::kFull, {}) - sure.cov / alpha).norm(),
              1e-6 * sure.cov.norm() / alpha);
  }
}

TEST(EdgeCovariance, IsNeverBelowWhatTheFilterReports) {
  const DrMotion unsure = ForwardMotion(0.01);
  const Matrix6d strongest = EdgeCovariance(unsure, 1e6, Variant::kFull, {});
  EXPECT_LT((strongest - unsure.reported_cov).norm(), 1e-4 * unsure.reported_cov.norm());
  const Matrix6d weak = EdgeCovariance(unsure, 0.1, Variant::kFull, {});
  EXPECT_LT((weak - 10 * unsure.cov).norm(), 1e-9 * weak.norm());
}

TEST(EdgeCovariance, OfABaselineIsScaledWithoutABound) {
  const DrMotion unsure = ForwardMotion(0.01);
  EXPECT_LT((EdgeCovariance(unsure, 1e6, Variant::kFixed, {}) - 1e-6 * unsure.cov).norm(),
            1e-15 * unsure.cov.norm());
}

TEST(LoopEdgeCovariance, CountsNoMoreThanDrift) {
  const DrMotion sure = ForwardMotion(1e-9);
  EXPECT_LT((LoopEdgeCovariance(sure, 1000, Variant::kFull, {}) - sure.cov).norm(),
            1e-6 * sure.cov.norm());
  EXPECT_LT((LoopEdgeCovariance(sure, 0.1, Variant::kFull, {}) - 10 * sure.cov).norm(),
            1e-5 * sure.cov.norm());
}

TEST(WholeMapEdgeCovariance, HasTheWayOfTheFilterAndTheTurnOfLocalBa) {
  const DrMotion unsure = ForwardMotion(0.01);
  const double alpha = 0.1;
  const double inflation = VisionInflation().head<3>().squaredNorm() / 3;
  const Matrix6d cov = WholeMapEdgeCovariance(unsure, alpha, Variant::kFull, {});
  const Eigen::Matrix3d turn_known = cov.inverse().topLeftCorner<3, 3>().inverse();
  const Eigen::Matrix3d way = unsure.reported_cov.topLeftCorner<3, 3>();
  EXPECT_LT((turn_known * inflation - way).norm(), 0.05 * way.norm());
  const Eigen::Matrix3d turn =
      EdgeCovariance(unsure, alpha, Variant::kFull, {}).inverse().bottomRightCorner<3, 3>();
  EXPECT_LT((cov.inverse().bottomRightCorner<3, 3>() - turn).norm(), 1e-6 * turn.norm());
}

TEST(WholeMapEdgeCovariance, IsThatOfLocalBaForABaselineAndForASourceWithoutCovariance) {
  const DrMotion unsure = ForwardMotion(0.01);
  const DrMotion silent = ForwardMotion(0);
  EXPECT_EQ(WholeMapEdgeCovariance(unsure, 2.0, Variant::kFixed, {}),
            EdgeCovariance(unsure, 2.0, Variant::kFixed, {}));
  EXPECT_EQ(WholeMapEdgeCovariance(silent, 2.0, Variant::kFull, {}),
            EdgeCovariance(silent, 2.0, Variant::kFull, {}));
}

TEST(EffectiveScale, IsAlphaWithoutABoundAndLessWhereItActs) {
  const Matrix6d cov = NominalCovariance(Milliseconds(100), {});
  const DrScale alpha{4, 100};
  const DrScale free = EffectiveScale(cov, ScaledCovariance(cov, alpha, Matrix6d::Zero()));
  EXPECT_NEAR(free.translation, alpha.translation, 1e-9);
  EXPECT_NEAR(free.rotation, alpha.rotation, 1e-9);
  // A source that says of itself no more than the nominal noise counts for no more than that.
  const DrScale bounded = EffectiveScale(cov, ScaledCovariance(cov, alpha, cov));
  EXPECT_NEAR(bounded.translation, 1, 1e-9);
  EXPECT_NEAR(bounded.rotation, 1, 1e-9);
  // One of three axes that is bounded at 1 leaves the harmonic mean of 1, 4 and 4.
  Matrix6d one_axis = 1e-3 * cov;
  one_axis(0, 0) = cov(0, 0);
  EXPECT_NEAR(EffectiveScale(cov, ScaledCovariance(cov, alpha, one_axis)).translation, 2, 1e-9);
}

TEST(SqrtInformation, IsTheRootOfTheInverse) {
  const Matrix6d cov = ForwardMotion(0.01).cov;
  const Matrix6d S = SqrtInformation(cov);
  EXPECT_LT((S.transpose() * S * cov - Matrix6d::Identity()).norm(), 1e-9);
}

}  // namespace
}  // namespace gw

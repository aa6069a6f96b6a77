// The covariance of the pose against the sample covariance of many noisy tracks.
#include "frontend/core/pose_uncertainty.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "common/core/random.h"

namespace gw::frontend {
namespace {

Vector6d Draw(CounterRng* rng, const Matrix6d& cov) {
  Vector6d normal;
  for (int i = 0; i < 6; ++i) normal[i] = rng->Normal();
  return Eigen::LLT<Matrix6d>(cov + 1e-18 * Matrix6d::Identity()).matrixL() * normal;
}

Matrix6d Diagonal(double translation, double rotation) {
  Vector6d d;
  d << Eigen::Vector3d::Constant(translation * translation),
      Eigen::Vector3d::Constant(rotation * rotation);
  return d.asDiagonal();
}

// Images 0..19 with vision, then blind. One step of motion and its noise.
struct Track {
  SE3 T_ab{ExpSO3({0, 0.02, 0}), {0.002, 0, 0.02}};
  DrNoise noise;
  Matrix6d vision_information = 25.0 * Diagonal(1.0 / 0.004, 1.0 / 0.002);
  Matrix6d prior_information = 4.0 * Diagonal(1.0 / 0.001, 1.0 / 0.001);

  Track() {
    noise.white = Diagonal(0.001, 0.0005);
    noise.lever = 0.033 * T_ab.inverse().Adjoint();
    noise.coherent = Diagonal(0.02, 0.004);
  }
};

TEST(PoseUncertainty, AgreesWithTheSpreadOfManyTracks) {
  constexpr int kTracks = 4000;
  constexpr int kImages = 60;
  constexpr int kSeeing = 20;
  const Track track;
  const Matrix6d hessian_inverse = (track.vision_information + track.prior_information).inverse();
  const Matrix6d K = hessian_inverse * track.vision_information;
  const Matrix6d A = track.T_ab.inverse().Adjoint();
  const Matrix6d vision_cov = VisionCovariance(track.vision_information);

  PoseUncertainty uncertainty;
  uncertainty.Reset(Matrix6d::Identity() * 1e-12);
  for (int i = 0; i < kImages; ++i) {
    uncertainty.Predict(track.T_ab, track.noise);
    if (i < kSeeing) uncertainty.Update(track.vision_information, track.prior_information);
  }

  Matrix6d spread = Matrix6d::Zero();
  for (int t = 0; t < kTracks; ++t) {
    CounterRng rng(5, 0, static_cast<uint64_t>(t));
    const Vector6d c = Draw(&rng, track.noise.coherent);
    Vector6d x = Vector6d::Zero();
    for (int i = 0; i < kImages; ++i) {
      x = A * x + track.noise.lever * c + Draw(&rng, track.noise.white);
      if (i < kSeeing) x += K * (Draw(&rng, vision_cov) - x);
    }
    spread += x * x.transpose() / kTracks;
  }
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(spread(i, i) / uncertainty.cov()(i, i), 1.0, 0.1) << i;
  }
}

TEST(PoseUncertainty, BlindItIsTheGrowthThatDeadReckoningReports) {
  const Track track;
  PoseUncertainty uncertainty;
  uncertainty.Reset(Matrix6d::Zero());
  Matrix6d white = Matrix6d::Zero();
  Matrix6d lever = Matrix6d::Zero();
  const Matrix6d A = track.T_ab.inverse().Adjoint();
  for (int i = 0; i < 300; ++i) {
    uncertainty.Predict(track.T_ab, track.noise);
    white = A * white * A.transpose() + track.noise.white;
    lever = A * lever + track.noise.lever;
  }
  const Matrix6d expected = white + lever * track.noise.coherent * lever.transpose();
  EXPECT_LT((uncertainty.cov() - expected).norm(), 1e-9 * expected.norm());
}

TEST(PoseUncertainty, VisionAloneForgetsTheDrift) {
  const Track track;
  PoseUncertainty uncertainty;
  uncertainty.Reset(Diagonal(1.0, 0.5));
  uncertainty.Predict(track.T_ab, track.noise);
  uncertainty.Update(track.vision_information, Matrix6d::Zero());
  const Matrix6d expected = VisionCovariance(track.vision_information);
  EXPECT_LT((uncertainty.cov() - expected).norm(), 1e-9 * expected.norm());
}

}  // namespace
}  // namespace gw::frontend

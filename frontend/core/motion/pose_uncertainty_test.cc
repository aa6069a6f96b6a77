// The covariance of the pose against the sample covariance of many noisy tracks.
#include "frontend/core/motion/pose_uncertainty.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <optional>
#include <vector>

#include "common/core/random.h"
#include "common/good_weights/vision_noise.h"

namespace gw::frontend {
namespace {

template <int kSize>
Eigen::Matrix<double, kSize, 1> Draw(CounterRng* rng,
                                     const Eigen::Matrix<double, kSize, kSize>& cov) {
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  Eigen::Matrix<double, kSize, 1> normal;
  for (int i = 0; i < kSize; ++i) normal[i] = rng->Normal();
  return Eigen::LLT<Matrix>(cov + 1e-18 * Matrix::Identity()).matrixL() * normal;
}

Matrix6d Diagonal(double translation, double rotation) {
  Vector6d d;
  d << Eigen::Vector3d::Constant(translation * translation),
      Eigen::Vector3d::Constant(rotation * rotation);
  return d.asDiagonal();
}

constexpr DurationUs kPeriod{33333};

// Images 0..19 with vision, then blind. One step of motion and its noise.
struct Track {
  SE3 T_ab{ExpSO3({0, 0.02, 0}), {0.002, 0, 0.02}};
  DrNoise noise;
  Matrix6d vision_information = 25.0 * Diagonal(1.0 / 0.004, 1.0 / 0.002);
  Matrix6d prior_information = 4.0 * Diagonal(1.0 / 0.001, 1.0 / 0.001);

  Track() {
    noise.white = Diagonal(0.001, 0.0005);
    noise.lever.leftCols<6>() = 0.033 * T_ab.inverse().Adjoint();
    noise.lever.col(kWayScale).head<3>() = T_ab.translation();
    noise.coherent.topLeftCorner<6, 6>() = Diagonal(0.02, 0.004);
    noise.coherent(kWayScale, kWayScale) = 0.1 * 0.1;
  }
};

TEST(PoseUncertainty, AgreesWithTheSpreadOfManyTracks) {
  constexpr int kTracks = 4000;
  constexpr int kImages = 60;
  constexpr int kSeeing = 20;
  constexpr int kSpan = 10;
  const Track track;
  const Matrix6d hessian_inverse = (track.vision_information + track.prior_information).inverse();
  const Matrix6d K = hessian_inverse * track.vision_information;
  const Matrix6d A = track.T_ab.inverse().Adjoint();
  const Matrix6d vision_cov = VisionCovariance(track.vision_information);
  const double kept = std::exp(-kPeriod.seconds() / PoseUncertainty::kVisionMemory);

  PoseUncertainty uncertainty;
  uncertainty.Reset(Matrix6d::Identity() * 1e-12);
  SE3 T_WC;
  std::vector<Matrix6d> motion_cov;  // of the motion over the kSpan images before each
  for (int i = 0; i < kImages; ++i) {
    uncertainty.Predict(track.T_ab, track.noise, kPeriod);
    T_WC = T_WC * track.T_ab;
    if (i < kSeeing) uncertainty.Update(track.vision_information, track.prior_information);
    const auto motion = uncertainty.Remember({i * kPeriod.us}, T_WC, {kSpan * kPeriod.us});
    ASSERT_EQ(motion.has_value(), i >= kSpan - 1) << i;  // one image less is near enough
    motion_cov.push_back(motion ? motion->cov : Matrix6d::Zero());
    if (i >= kSpan) {
      EXPECT_EQ(motion->length.us, kSpan * kPeriod.us);
    }
  }

  Matrix6d A_span = Matrix6d::Identity();
  for (int i = 0; i < kSpan; ++i) A_span = A * A_span;
  Matrix6d spread = Matrix6d::Zero();
  std::vector<Vector6d> motion_spread(kImages, Vector6d::Zero());
  for (int t = 0; t < kTracks; ++t) {
    CounterRng rng(5, 0, static_cast<uint64_t>(t));
    const auto c = Draw(&rng, track.noise.coherent);
    Vector6d x = Vector6d::Zero();
    Vector6d v = Draw(&rng, vision_cov);
    std::vector<Vector6d> errors;
    for (int i = 0; i < kImages; ++i) {
      x = A * x + track.noise.lever * c + Draw(&rng, track.noise.white);
      v = kept * v + std::sqrt(1 - kept * kept) * Draw(&rng, vision_cov);
      if (i < kSeeing) x += K * (v - x);
      errors.push_back(x);
      if (i < kSpan) continue;
      const Vector6d motion_error = x - A_span * errors[i - kSpan];
      motion_spread[i] += motion_error.cwiseAbs2() / kTracks;
    }
    spread += x * x.transpose() / kTracks;
  }
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(spread(i, i) / uncertainty.cov()(i, i), 1.0, 0.1) << i;
    // Seen all the time, going blind in it, blind all the time.
    for (const int image : {kSeeing - 1, kSeeing + kSpan / 2, kImages - 1}) {
      EXPECT_NEAR(motion_spread[image][i] / motion_cov[image](i, i), 1.0, 0.1) << image << i;
    }
  }
}

TEST(PoseUncertainty, BlindItIsTheGrowthThatDeadReckoningReports) {
  const Track track;
  PoseUncertainty uncertainty;
  uncertainty.Reset(Matrix6d::Zero());
  Matrix6d white = Matrix6d::Zero();
  DrLever lever = DrLever::Zero();
  const Matrix6d A = track.T_ab.inverse().Adjoint();
  for (int i = 0; i < 300; ++i) {
    uncertainty.Predict(track.T_ab, track.noise, kPeriod);
    white = A * white * A.transpose() + track.noise.white;
    lever = A * lever + track.noise.lever;
  }
  const Matrix6d expected = white + lever * track.noise.coherent * lever.transpose();
  EXPECT_LT((uncertainty.cov() - expected).norm(), 1e-9 * expected.norm());
}

// Image by image, and over the motion of the last second, it is what dead reckoning composes in one
// piece, also while a bias and a scale are being learnt (but for what is learnt between two
// images).
TEST(PoseUncertainty, FollowsWhatDeadReckoningLearns) {
  DrHistory history;
  SE3 T_OB;
  for (int i = 0; i <= 400; ++i) {
    DrState s;
    s.utime = {i * 10000};
    const double turn = i < 200 ? 0.5 : -0.5;  // rad/s
    if (i > 0) T_OB = T_OB * SE3::Exp((Vector6d() << 0.005, 0, 0, 0, 0, 0.01 * turn).finished());
    s.T_OB = T_OB;
    s.v_OB_B = {0.5, 0, 0};
    s.w_OB_B = {0, 0, turn};
    s.cov_twist_white = Diagonal(1e-3, 1e-3);
    s.cov_twist_coherent(5, 5) = 1e-4 * std::exp(-0.005 * i);
    s.turn_scale_sigma = 0.01 * std::exp(-0.004 * i);
    ASSERT_TRUE(history.Push(s));
  }
  PoseUncertainty uncertainty;
  uncertainty.Reset(Matrix6d::Zero());
  std::optional<PoseUncertainty::Motion> motion;
  for (int k = 1; k <= 100; ++k) {
    const Utime a{(k - 1) * 40000}, b{k * 40000};
    DrNoise noise;
    const auto increment = history.Increment(a, b, &noise);
    ASSERT_TRUE(increment);
    uncertainty.Predict(increment->T_BaBb, noise, b - a);
    motion = uncertainty.Remember(b, *history.PoseAt(b), Milliseconds(1000));
  }
  const auto whole = history.Increment({0}, {4000000});
  ASSERT_TRUE(whole);
  EXPECT_LT((uncertainty.cov() - whole->cov).norm(), 0.02 * whole->cov.norm());
  const auto second = history.Increment({3000000}, {4000000});
  ASSERT_TRUE(second && motion);
  EXPECT_EQ(motion->length.us, 1000000);
  EXPECT_LT((motion->cov - second->cov).norm(), 0.02 * second->cov.norm());
}

TEST(PoseUncertainty, VisionAloneForgetsTheDrift) {
  const Track track;
  PoseUncertainty uncertainty;
  uncertainty.Reset(Diagonal(1.0, 0.5));
  uncertainty.Predict(track.T_ab, track.noise, kPeriod);
  uncertainty.Update(track.vision_information, Matrix6d::Zero());
  const Matrix6d expected = VisionCovariance(track.vision_information);
  EXPECT_LT((uncertainty.cov() - expected).norm(), 1e-9 * expected.norm());
}

TEST(PoseUncertainty, MotionHoldsWhatTheMapMovedInIt) {
  const Track track;
  const auto motion_over_ten_images = [&](const Vector6d& shift) {
    PoseUncertainty uncertainty;
    SE3 T_WC;
    for (int i = 0;; ++i) {
      if (i > 0) {
        uncertainty.Predict(track.T_ab, track.noise, kPeriod);
        T_WC = T_WC * track.T_ab;
      }
      uncertainty.Update(track.vision_information, track.prior_information);
      const auto motion = uncertainty.Remember(Utime{} + DurationUs{kPeriod.us * i}, T_WC,
                                               DurationUs{kPeriod.us * 10});
      if (i == 10) return motion->cov;
      if (i == 7) uncertainty.Shift(shift);
    }
  };
  Vector6d shift;
  shift << 0.02, 0, -0.01, 0.001, 0.002, 0;
  const Matrix6d grown = motion_over_ten_images(shift) - motion_over_ten_images(Vector6d::Zero());
  const SE3 rest = track.T_ab * track.T_ab * track.T_ab;
  const Vector6d seen = rest.inverse().Adjoint() * shift;  // at the end of the motion
  EXPECT_LT((grown - seen * seen.transpose()).norm(), 1e-9 * seen.squaredNorm());
}

}  // namespace
}  // namespace gw::frontend

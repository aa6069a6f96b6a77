// Section III of Du, Peng, Vela, "Good Weights", arXiv 2509.22910, to the letter: what `method:
// paper` computes, against values by hand.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "common/good_weights/alpha.h"
#include "common/good_weights/covariance.h"
#include "common/good_weights/edge_covariance.h"
#include "common/good_weights/quality.h"
#include "common/vision/pose_optimizer.h"

namespace gw {
namespace {

const DrWeightConfig kPaper{.method = Method::kPaper};
constexpr DurationUs kFrame{33333};  // 0.99999 frame periods

// Reported noise far above the nominal one.
DrMotion UnsureMotion() {
  DrIncrement dr;
  dr.utime_begin = {0};
  dr.utime_end = {kFrame.us};
  dr.cov = 4 * Matrix6d::Identity();
  return CameraMotion(dr, SE3(), kPaper);
}

TEST(PaperLaw, OneAlphaForAllAxes) {
  const DrScale scale = PriorScale(Variant::kFull, 0.75, 0.0, kPaper);
  EXPECT_NEAR(scale.rotation, 1.0, 1e-12);  // 0.1 * 10000^0.25
  EXPECT_EQ(scale.translation, scale.rotation);
}

// Q = 0.5 * 450/600 + 0.5 * 30/120 = 0.5; alpha = 0.1 * 10000^0.5 = 10; information = alpha /
// (0.004 m)^2 and alpha / (0.1 deg)^2.
TEST(PaperLaw, InformationIsAlphaOverTheNominalNoise) {
  const double q = ImageQuality({450, 30}, kPaper);
  EXPECT_NEAR(q, 0.5, 1e-12);
  const double alpha = InformationScale(q, kPaper);
  EXPECT_NEAR(alpha, 10.0, 1e-12);
  const Matrix6d information =
      EdgeCovariance(UnsureMotion(), alpha, Variant::kFull, kPaper).inverse();
  EXPECT_NEAR(information(0, 0), 10 / 1.6e-5 / 0.99999, 1e-3);
  EXPECT_NEAR(information(5, 5), 10 / 3.0461741978670857e-06 / 0.99999, 1e-3);
  EXPECT_NEAR(information(0, 5), 0, 1e-9);
}

TEST(PaperLaw, GlobalBundleAdjustmentKeepsTheWeight) {
  const DrMotion motion = UnsureMotion();
  EXPECT_EQ(WholeMapEdgeCovariance(motion, 300, Variant::kFull, kPaper),
            EdgeCovariance(motion, 300, Variant::kFull, kPaper));
}

TEST(PaperLaw, OneChangeIsOneChange) {
  DrWeightConfig bound = kPaper;
  bound.changed.Insert(Departure::kBound);
  const DrMotion motion = UnsureMotion();
  EXPECT_NEAR(EdgeCovariance(motion, 10, Variant::kFull, bound)(0, 0), 4, 1e-9);
  EXPECT_EQ(PriorScale(Variant::kFull, 0.75, 0.0, bound).translation,
            PriorScale(Variant::kFull, 0.75, 0.0, bound).rotation);
}

// Equation 6 with one landmark straight ahead at z = 1 m, seen 2 px right of where the prior has
// it, fx = 100 px, and prior information a for x and b for the angle about y only as far as they
// compete: the pixel moves by -100 (dx + dtheta) (small motions), so that by Lagrange dx : dtheta =
// 1/a : 1/b, and 2 + 100 (dx + dtheta) times 100 equals -a dx.
TEST(PaperLaw, ThePriorCarriesWhatASingleLandmarkLeavesOpen) {
  RectifiedCamera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 100;
  camera.cx = 320;
  camera.cy = 240;
  camera.baseline_m = 0.1;
  PosePrior prior;
  const double a = 1e4, b = 4e4;
  prior.information.diagonal() << a, 1e9, 1e9, 1e9, b, 1e9;
  LandmarkObservation seen;
  seen.p_W = {0, 0, 1};
  seen.pixel.u = 322;
  seen.pixel.v = 240;
  const PoseEstimate e = OptimizePose(camera, SE3(), {seen}, prior);
  // -100 (dx + t) - 2 = r, 100 r = ... : dx = -2 / (100 (1 + a/b) + a / 100), t = dx a / b.
  const double dx = -2 / (100 * (1 + a / b) + a / 100);
  EXPECT_NEAR(e.T_WC.translation().x(), dx, 1e-5);
  EXPECT_NEAR(LogSO3(e.T_WC.rotation()).y(), dx * a / b, 1e-5);
  EXPECT_EQ(e.num_inliers, 1);
}

}  // namespace
}  // namespace gw

#include "tools/robot/calibrate/refine_stereo.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/camera/camera_model.h"
#include "common/core/random.h"

namespace gw::tools {
namespace {

CameraCalibration Nominal() {
  CameraCalibration c;
  c.kind = CameraKind::kStereo;
  c.width = 640;
  c.height = 480;
  c.left = {380, 380, 320, 240, {}};
  c.right = c.left;
  c.T_C0C1 = SE3(Eigen::Quaterniond::Identity(), {0.12, 0, 0});
  return c;
}

CameraCalibration Knocked(CameraCalibration c) {
  c.T_C0C1 = SE3(ExpSO3({0.001, -0.004, 0.0015}), c.T_C0C1.translation());
  c.right.fx *= 1.001;
  c.right.fy *= 1.001;
  c.right.cx -= 1.0;
  return c;
}

Eigen::Vector2d Project(const PinholeIntrinsics& eye, const Eigen::Vector3d& p) {
  const Eigen::Vector2d n = Distort(eye, {p.x() / p.z(), p.y() / p.z()});
  return {eye.fx * n.x() + eye.cx, eye.fy * n.y() + eye.cy};
}

struct Drive {
  double step_m = 0.15;
  double turn_rad = 0.02;
  double noise_px = 0.2;
  double outliers = 0.1;
};

// What a tracker would see that drives through points 1 to 20 m away.
std::vector<PairTracks> Simulate(const CameraCalibration& truth, const Drive& drive) {
  std::vector<PairTracks> pairs;
  for (uint64_t pair = 0; pair < 12; ++pair) {
    const double side = pair % 3 == 0 ? -1.0 : 1.0;
    const SE3 T_1_0 = SE3(ExpSO3({0.2 * drive.turn_rad, side * drive.turn_rad, 0}),
                          {0.2 * drive.step_m, 0, -drive.step_m});
    PairTracks tracks;
    for (uint64_t i = 0; i < 150; ++i) {
      CounterRng rng(7, pair, i);
      const Eigen::Vector2d pixel(rng.Uniform(20, truth.width - 20),
                                  rng.Uniform(20, truth.height - 20));
      const double depth = 1.0 / rng.Uniform(1.0 / 20, 1.0);
      const auto n = Undistort(truth.left, {(pixel.x() - truth.left.cx) / truth.left.fx,
                                            (pixel.y() - truth.left.cy) / truth.left.fy});
      const Eigen::Vector3d p = depth * Eigen::Vector3d(n->x(), n->y(), 1.0);
      const SE3 T_RightLeft = truth.T_C0C1.inverse();
      StereoTrack t{pixel, Project(truth.right, T_RightLeft * p), Project(truth.left, T_1_0 * p),
                    Project(truth.right, T_RightLeft * (T_1_0 * p))};
      for (Eigen::Vector2d* z : {&t.left0, &t.right0, &t.left1, &t.right1}) {
        *z += drive.noise_px * Eigen::Vector2d(rng.Normal(), rng.Normal());
      }
      if (rng.Uniform() < drive.outliers) t.left1.x() += rng.Uniform(3, 30);
      tracks.push_back(t);
    }
    pairs.push_back(tracks);
  }
  return pairs;
}

// Largest error (px) of the right eye's pixel, over the image and over distances.
double LargestError(const CameraCalibration& a, const CameraCalibration& b) {
  double largest = 0;
  for (double u = 0; u <= a.width; u += 80) {
    for (double v = 0; v <= a.height; v += 80) {
      const auto n = Undistort(a.left, {(u - a.left.cx) / a.left.fx, (v - a.left.cy) / a.left.fy});
      for (const double depth : {2.0, 1000.0}) {
        const Eigen::Vector3d p = depth * Eigen::Vector3d(n->x(), n->y(), 1.0);
        largest = std::max(largest, (Project(a.right, a.T_C0C1.inverse() * p) -
                                     Project(b.right, b.T_C0C1.inverse() * p))
                                        .norm());
      }
    }
  }
  return largest;
}

TEST(RefineStereo, FindsAKnockedRightEye) {
  const CameraCalibration given = Nominal();
  const CameraCalibration truth = Knocked(given);
  ASSERT_GT(LargestError(given, truth), 2.0);
  const auto refined = RefineStereo(given, Simulate(truth, {}));
  ASSERT_TRUE(refined) << refined.error().message;
  EXPECT_LT(LargestError(refined->camera, truth), 0.15);
  EXPECT_LT(refined->rms_after_px, 0.3);
  EXPECT_GT(refined->rms_before_px, 1.5 * refined->rms_after_px);
  EXPECT_LT(refined->sigma_shift_px, 0.05);
  EXPECT_GT(refined->num_tracks, 1500);  // 10 % of 1800 are outliers
  EXPECT_LT(refined->num_tracks, 1700);
}

TEST(RefineStereo, AGoodCalibrationStays) {
  const CameraCalibration truth = Nominal();
  const auto refined = RefineStereo(truth, Simulate(truth, {}));
  ASSERT_TRUE(refined) << refined.error().message;
  EXPECT_LT(std::abs(refined->shift_centre_px), 4 * refined->sigma_shift_px);
  EXPECT_LT(LargestError(refined->camera, truth), 0.15);
}

TEST(RefineStereo, LensesWithDistortionThatAreNotRectified) {
  CameraCalibration given = Nominal();
  given.left.radtan = {-0.28, 0.07, 1e-4, 2e-5, 0};
  given.right.radtan = {-0.27, 0.06, -1e-4, 3e-5, 0};
  given.right.fx = given.right.fy = 384;
  given.T_C0C1 = SE3(ExpSO3({0.002, 0.01, -0.003}), {0.12, 0.001, -0.001});
  CameraCalibration truth = given;
  truth.T_C0C1 =
      SE3(given.T_C0C1.rotation() * ExpSO3({0.001, -0.003, 0.001}), given.T_C0C1.translation());
  const auto refined = RefineStereo(given, Simulate(truth, {}));
  ASSERT_TRUE(refined) << refined.error().message;
  EXPECT_LT(LargestError(refined->camera, truth), 0.2);
}

TEST(RefineStereo, SaysSoWhenTheCameraDoesNotMove) {
  const CameraCalibration given = Nominal();
  Drive still;
  still.step_m = 0;
  const auto refined = RefineStereo(given, Simulate(Knocked(given), still));
  ASSERT_FALSE(refined);
  EXPECT_EQ(refined.error().code, ErrorCode::kBadData);
  EXPECT_THAT(refined.error().message, testing::HasSubstr("record a drive"));
}

TEST(RefineStereo, SaysSoWhenThereIsTooLittleToSee) {
  const CameraCalibration given = Nominal();
  EXPECT_FALSE(RefineStereo(given, {}));
  auto pairs = Simulate(given, {});
  pairs.resize(2);
  EXPECT_FALSE(RefineStereo(given, pairs));
  CameraCalibration rgbd = given;
  rgbd.kind = CameraKind::kRgbd;
  EXPECT_EQ(RefineStereo(rgbd, {}).error().code, ErrorCode::kBadConfig);
}

}  // namespace
}  // namespace gw::tools

#include "common/camera/camera_model.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "common/core/random.h"

namespace gw {
namespace {

// freiburg1 of the TUM RGB-D data set: strong distortion with a sixth-order term.
PinholeIntrinsics Freiburg1() {
  return {517.3, 516.5, 318.6, 255.3, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}};
}

Calibration StereoCalibration() {
  Calibration c;
  c.camera.kind = CameraKind::kStereo;
  c.camera.width = 752;
  c.camera.height = 480;
  c.camera.left = {
      458.654, 457.296, 367.215, 248.375, {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0}};
  c.camera.right = {457.587,
                    456.134,
                    379.999,
                    255.238,
                    {-0.28368365, 0.07451284, -0.00010473, -3.55590700e-05, 0}};
  c.camera.T_C0C1 = SE3(ExpSO3({0.003, -0.015, 0.001}), {0.11, 0.0004, -0.0008});
  return c;
}

TEST(Distortion, UndistortInvertsDistortOverTheImage) {
  const PinholeIntrinsics camera = Freiburg1();
  for (int v = 0; v <= 480; v += 16) {
    for (int u = 0; u <= 640; u += 16) {
      const Eigen::Vector2d d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy);
      const auto n = Undistort(camera, d);
      ASSERT_TRUE(n.ok()) << u << " " << v;
      EXPECT_LT((Distort(camera, *n) - d).norm() * camera.fx, 1e-6);
    }
  }
}

TEST(StereoRectification, SamePointLandsOnTheSameRowWithTheRightDisparity) {
  const auto geometry = MakeCameraGeometry(StereoCalibration());
  ASSERT_TRUE(geometry.ok());
  ASSERT_TRUE(geometry->rectification.needed);
  const CameraCalibration& c = geometry->calibration.camera;
  const RectifiedCamera& r = geometry->rectified;
  EXPECT_NEAR(r.baseline_m, 0.11, 1e-3);
  for (int i = 0; i < 300; ++i) {
    CounterRng rng(1, 0, i);
    const Eigen::Vector3d p_C0(rng.Uniform(-1, 1), rng.Uniform(-0.6, 0.6), rng.Uniform(2, 8));
    // True pixels in both source images.
    const auto project = [](const PinholeIntrinsics& eye, const Eigen::Vector3d& p) {
      const Eigen::Vector2d n = Distort(eye, {p.x() / p.z(), p.y() / p.z()});
      return Eigen::Vector2d(eye.fx * n.x() + eye.cx, eye.fy * n.y() + eye.cy);
    };
    const Eigen::Vector2d left = project(c.left, p_C0);
    const Eigen::Vector2d right = project(c.right, c.T_C0C1.inverse() * p_C0);
    // Where the rectified cameras should see it.
    const Eigen::Vector3d p_Rect = geometry->rectification.R_C0Rect.transpose() * p_C0;
    const Eigen::Vector2d uv = r.Project(p_Rect);
    const Eigen::Vector2d uv_right(uv.x() - r.bf() / p_Rect.z(), uv.y());
    EXPECT_LT((RectifiedToSource(r, c.left, geometry->rectification.R_C0Rect, uv) - left).norm(),
              1e-9);
    EXPECT_LT(
        (RectifiedToSource(r, c.right, geometry->rectification.R_C1Rect, uv_right) - right).norm(),
        1e-9);
  }
}

TEST(CameraGeometry, RefusesSwappedEyesAndNamesTheField) {
  Calibration c = StereoCalibration();
  c.camera.T_C0C1 = SE3(Eigen::Quaterniond::Identity(), {-0.11, 0, 0});
  const auto geometry = MakeCameraGeometry(c);
  ASSERT_FALSE(geometry.ok());
  EXPECT_EQ(geometry.error().code, ErrorCode::kBadConfig);
  EXPECT_NE(geometry.error().message.find("T_C0C1"), std::string::npos);
}

TEST(CameraGeometry, RectifiedPairIsUsedAsItIs) {
  Calibration c = StereoCalibration();
  c.camera.left = c.camera.right = {718.856, 718.856, 367.2, 185.2, {}};
  c.camera.T_C0C1 = SE3(Eigen::Quaterniond::Identity(), {0.537, 0, 0});
  const auto geometry = MakeCameraGeometry(c);
  ASSERT_TRUE(geometry.ok());
  EXPECT_FALSE(geometry->rectification.needed);
  EXPECT_DOUBLE_EQ(geometry->rectified.bf(), 718.856 * 0.537);
}

}  // namespace
}  // namespace gw

#include "frontend/core/features/image_undistorter.h"

#include <gtest/gtest.h>

#include <array>

#include "common/core/random.h"

namespace gw::frontend {
namespace {

CameraGeometry Geometry(const std::array<double, 5>& radtan) {
  Calibration c;
  c.camera.width = 640;
  c.camera.height = 480;
  c.camera.left = {.fx = 517.3, .fy = 516.5, .cx = 318.6, .cy = 255.3, .radtan = radtan};
  return MakeCameraGeometry(c).value();
}

TEST(ImageUndistorter, AgreesWithTheCameraModelToAFiftiethOfAPixel) {
  for (const std::array<double, 5>& radtan : {std::array{0.2624, -0.9531, -0.0054, 0.0026, 1.1633},
                                              std::array{-0.283, 0.0739, 0.00019, 1.76e-05, 0.0}}) {
    const CameraGeometry geometry = Geometry(radtan);
    const ImageUndistorter undistorter(geometry);
    const PinholeIntrinsics& camera = geometry.calibration.camera.left;
    CounterRng rng(1, 0, 0);
    for (int i = 0; i < 1000; ++i) {
      const Eigen::Vector2d pixel(rng.Uniform(0, 639), rng.Uniform(0, 479));
      const Eigen::Vector2d exact = Undistort(camera, {(pixel.x() - camera.cx) / camera.fx,
                                                       (pixel.y() - camera.cy) / camera.fy})
                                        .value();
      const auto uv =
          undistorter.Undistort(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
      ASSERT_TRUE(uv.has_value());
      EXPECT_NEAR(uv->x(), camera.fx * exact.x() + camera.cx, 0.02);
      EXPECT_NEAR(uv->y(), camera.fy * exact.y() + camera.cy, 0.02);
    }
  }
}

TEST(ImageUndistorter, LeavesPixelsOfAnUndistortedCameraAlone) {
  const ImageUndistorter undistorter(Geometry({}));
  EXPECT_EQ(*undistorter.Undistort(12.25f, 400.5f), Eigen::Vector2f(12.25f, 400.5f));
}

TEST(ImageUndistorter, RefusesPixelsOutsideTheImageAndOutsideTheCalibration) {
  const ImageUndistorter plain(Geometry({}));
  EXPECT_FALSE(plain.Undistort(-0.1f, 10));
  EXPECT_FALSE(plain.Undistort(10, 479.5f));
  // This distortion folds over well inside the image.
  const ImageUndistorter folding(Geometry({-2.0, 0, 0, 0, 0}));
  EXPECT_FALSE(folding.Undistort(1, 1));
  EXPECT_TRUE(folding.Undistort(320, 250));
}

}  // namespace
}  // namespace gw::frontend

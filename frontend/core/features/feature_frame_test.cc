#include "frontend/core/features/feature_frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "frontend/core/features/image_test_pattern.h"
#include "frontend/core/features/tum_geometry.h"

namespace gw::frontend {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;

CameraGeometry StereoGeometry() {
  Calibration c;
  c.camera.kind = CameraKind::kStereo;
  c.camera.width = kWidth;
  c.camera.height = kHeight;
  c.camera.left = {.fx = 500, .fy = 500, .cx = 320, .cy = 240};
  c.camera.right = c.camera.left;
  c.camera.T_C0C1 = SE3(Eigen::Quaterniond::Identity(), {0.1, 0, 0});
  c.camera.depth_max_m = 20;
  return MakeCameraGeometry(c).value();
}

struct DepthBuffer {
  explicit DepthBuffer(uint16_t value) : pixels(static_cast<size_t>(kWidth) * kHeight, value) {}
  ImageView View() const {
    return {reinterpret_cast<const uint8_t*>(pixels.data()), kWidth, kHeight, 2 * kWidth,
            PixelFormat::kDepth16};
  }
  std::vector<uint16_t> pixels;
};

CameraFrame RgbdFrame(const ImageView& left, const ImageView& depth) {
  CameraFrame frame;
  frame.left = left;
  frame.depth = depth;
  return frame;
}

CameraFrame StereoFrame(const ImageView& left, const ImageView& right) {
  CameraFrame frame;
  frame.left = left;
  frame.right = right;
  return frame;
}

ImageBuffer Textured() {
  return Render(CellTexture(1, 10), kWidth, kHeight,
                [](double u, double v) { return Eigen::Vector2d(u, v); });
}

bool SameBytes(const FeatureFrame& a, const FeatureFrame& b) {
  if (a.features.size() != b.features.size() || a.descriptors != b.descriptors) return false;
  for (size_t i = 0; i < a.features.size(); ++i) {
    const Feature& f = a.features[i];
    const Feature& g = b.features[i];
    if (f.u != g.u || f.v != g.v || f.u_right != g.u_right || f.depth != g.depth ||
        f.angle != g.angle || f.level != g.level) {
      return false;
    }
  }
  return true;
}

TEST(FeatureExtractor, FindsTheFullNumberOfFeaturesWithDepthInATexturedRgbdImage) {
  FeatureExtractor extractor = FeatureExtractor::Create({}, TumGeometry()).value();
  const ImageBuffer image = Textured();
  const DepthBuffer depth(10000);  // 2 m
  FeatureFrame out;
  ASSERT_EQ(extractor.Extract(RgbdFrame(image.View(), depth.View()), &out),
            FeatureExtractor::Outcome::kOk);
  EXPECT_EQ(out.num_detected, 800);
  ASSERT_EQ(out.features.size(), 800u);
  ASSERT_EQ(out.descriptors.size(), 800u);
  for (const Feature& f : out.features) {
    EXPECT_NEAR(f.depth, 2.0f, 1e-5f);
    EXPECT_NEAR(f.u - f.u_right, 517.3f * 0.08f / 2.0f, 1e-3f);
  }
}

TEST(FeatureExtractor, FindsNothingInABlankImage) {
  FeatureExtractor extractor = FeatureExtractor::Create({}, TumGeometry()).value();
  ImageBuffer image;
  image.Resize(kWidth, kHeight, kWidth);
  std::fill(image.pixels.begin(), image.pixels.end(), uint8_t{128});
  const DepthBuffer depth(10000);
  FeatureFrame out;
  EXPECT_EQ(extractor.Extract(RgbdFrame(image.View(), depth.View()), &out),
            FeatureExtractor::Outcome::kOk);
  EXPECT_EQ(out.num_detected, 0);
  EXPECT_TRUE(out.features.empty());
}

TEST(FeatureExtractor, GivesTheSameBytesForTheSameFrameWhateverCameBefore) {
  const ImageBuffer image = Textured();
  const ImageBuffer other = Render(CellTexture(2, 17), kWidth, kHeight,
                                   [](double u, double v) { return Eigen::Vector2d(u, v); });
  const DepthBuffer depth(10000);
  FeatureExtractor a = FeatureExtractor::Create({}, TumGeometry()).value();
  FeatureExtractor b = FeatureExtractor::Create({}, TumGeometry()).value();
  FeatureFrame first, second, third;
  a.Extract(RgbdFrame(image.View(), depth.View()), &first);
  b.Extract(RgbdFrame(other.View(), depth.View()), &second);
  b.Extract(RgbdFrame(image.View(), depth.View()), &third);
  EXPECT_TRUE(SameBytes(first, third));
  EXPECT_FALSE(SameBytes(first, second));
}

TEST(FeatureExtractor, RefusesImagesThatDoNotFitAndLeavesNothingBehind) {
  FeatureExtractor extractor = FeatureExtractor::Create({}, TumGeometry()).value();
  const ImageBuffer image = Textured();
  const DepthBuffer depth(10000);
  const ImageView good = image.View();
  std::vector<ImageView> bad(5, good);
  bad[0] = {};
  bad[1].width = kWidth - 1;
  bad[2].height = kHeight + 1;
  bad[3].stride = kWidth - 1;
  bad[4].format = PixelFormat::kDepth16;
  for (const ImageView& left : bad) {
    FeatureFrame out;
    extractor.Extract(RgbdFrame(good, depth.View()), &out);
    EXPECT_EQ(extractor.Extract(RgbdFrame(left, depth.View()), &out),
              FeatureExtractor::Outcome::kBadImage);
    EXPECT_TRUE(out.features.empty());
    EXPECT_TRUE(out.descriptors.empty());
    EXPECT_EQ(out.num_detected, 0);
  }
}

TEST(FeatureExtractor, KeepsFeaturesWithoutDepthWhenTheDepthImageIsUnusable) {
  FeatureExtractor extractor = FeatureExtractor::Create({}, TumGeometry()).value();
  const ImageBuffer image = Textured();
  const DepthBuffer depth(10000);
  ImageView narrow = depth.View();
  narrow.width = kWidth / 2;
  for (const ImageView& view : {ImageView{}, narrow, image.View()}) {
    FeatureFrame out;
    EXPECT_EQ(extractor.Extract(RgbdFrame(image.View(), view), &out),
              FeatureExtractor::Outcome::kMissingDepth);
    EXPECT_EQ(out.num_detected, 800);
    EXPECT_THAT(out.features,
                testing::Each(testing::Truly([](const Feature& f) { return !f.has_depth(); })));
  }
}

TEST(FeatureExtractor, MeasuresStereoDisparityToATenthOfAPixelOfTheLevel) {
  FeatureExtractor extractor = FeatureExtractor::Create({}, StereoGeometry()).value();
  for (const double disparity : {4.0, 7.3, 12.5, 25.8}) {
    const CellTexture texture(3, 11);
    const ImageBuffer left = Render(
        texture, kWidth, kHeight, [](double u, double v) { return Eigen::Vector2d(u, v); }, 2, 1);
    const ImageBuffer right = Render(
        texture, kWidth, kHeight,
        [&](double u, double v) { return Eigen::Vector2d(u + disparity, v); }, 2, 2);
    FeatureFrame out;
    ASSERT_EQ(extractor.Extract(StereoFrame(left.View(), right.View()), &out),
              FeatureExtractor::Outcome::kOk);
    double sum = 0;
    int count = 0;
    int wrong = 0;
    for (const Feature& f : out.features) {
      if (!f.has_depth()) continue;
      const double error = (f.u - f.u_right - disparity) / std::pow(1.2, f.level);
      if (std::abs(error) > 1) {
        ++wrong;
        continue;
      }
      sum += error * error;
      ++count;
    }
    EXPECT_GT(count, 450) << disparity;
    EXPECT_LE(wrong, 3) << disparity;
    EXPECT_LT(std::sqrt(sum / count), 0.1) << disparity;
  }
}

TEST(FeatureExtractor, SeesOneEyeTwiceAndEyesThatAreExchanged) {
  FeatureExtractor extractor = FeatureExtractor::Create({}, StereoGeometry()).value();
  const CellTexture texture(3, 11);
  const auto eye = [&](double disparity, int noise) {
    return Render(
        texture, kWidth, kHeight,
        [&](double u, double v) { return Eigen::Vector2d(u + disparity, v); }, 2, noise);
  };
  const ImageBuffer left = eye(0, 1), right = eye(9, 2), far = eye(0.3, 2);
  FeatureFrame out;
  EXPECT_EQ(extractor.Extract(StereoFrame(left.View(), left.View()), &out),
            FeatureExtractor::Outcome::kOneEyeTwice);
  EXPECT_EQ(extractor.Extract(StereoFrame(right.View(), left.View()), &out),
            FeatureExtractor::Outcome::kEyesExchanged);
  EXPECT_GT(out.num_detected, 0) << "they may as well be of two instants";
  EXPECT_EQ(extractor.Extract(StereoFrame(left.View(), right.View()), &out),
            FeatureExtractor::Outcome::kOk);
  // All of it far away, in either order: there is nothing to tell them apart by.
  for (const auto& [a, b] : {std::pair(&left, &far), std::pair(&far, &left)}) {
    EXPECT_EQ(extractor.Extract(StereoFrame(a->View(), b->View()), &out),
              FeatureExtractor::Outcome::kOk);
  }
  // Nothing in common.
  const CellTexture other(4, 12);
  const ImageBuffer elsewhere = Render(
      other, kWidth, kHeight, [](double u, double v) { return Eigen::Vector2d(u, v); }, 2, 3);
  EXPECT_EQ(extractor.Extract(StereoFrame(left.View(), elsewhere.View()), &out),
            FeatureExtractor::Outcome::kOk);
}

TEST(FeatureExtractor, RefusesAConfigurationThatContradictsItself) {
  OrbConfig config;
  config.fast_threshold = 5;
  config.fast_threshold_low = 7;
  const Result<FeatureExtractor> result = FeatureExtractor::Create(config, TumGeometry());
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::kBadConfig);
}

}  // namespace
}  // namespace gw::frontend

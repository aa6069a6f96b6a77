// Lenses and sizes of cameras in bags: what the log holds is what an ideal pinhole camera sees.
// Where a direction lies in the source image is told by OpenCV's own projection.
#include <gmock/gmock.h>

#include <opencv2/calib3d.hpp>

#include "tools/data/import/ros_bytes.h"
#include "tools/data/import/rosbag.h"
#include "tools/data/import/test_bag.h"
#include "tools/data/import/test_folder.h"

namespace gw::importer {
namespace {

using testing::HasSubstr;

RosInfo Rational() {
  RosInfo info;
  info.model = "rational_polynomial";
  info.D = {0.3, -0.1, 0.002, -0.003, 0.02, 0.35, -0.05, 0.01};
  return info;
}
RosInfo Fisheye() {
  RosInfo info;
  info.model = "equidistant";
  info.D = {-0.08, 0.02, -0.01, 0.003};
  return info;
}

cv::Point2d Project(const RosInfo& info, const cv::Point3d& ray) {
  const cv::Matx33d K(info.focal_px, 0, info.centre_px, 0, info.focal_px, info.centre_px, 0, 0, 1);
  const std::vector<cv::Point3d> rays = {ray};
  std::vector<cv::Point2d> pixels;
  const cv::Vec3d none(0, 0, 0);
  if (info.model == "equidistant") {
    cv::fisheye::projectPoints(rays, pixels, none, none, K, info.D);
  } else {
    cv::projectPoints(rays, none, none, K, info.D, pixels);
  }
  return pixels.front();
}

const cv::Point3d kRay(0.3, -0.22, 1);

// A dark image with a bright spot of a few pixels where kRay is seen; colour on request.
std::vector<uint8_t> Spot(const RosInfo& info, int channels) {
  const cv::Point2d at = Project(info, kRay);
  std::vector<uint8_t> image;
  for (int v = 0; v < static_cast<int>(info.height); ++v) {
    for (int u = 0; u < static_cast<int>(info.width); ++u) {
      const double r2 = std::pow(u - at.x, 2) + std::pow(v - at.y, 2);
      const auto value = static_cast<uint8_t>(std::lround(200 * std::exp(-r2 / 4)));
      image.insert(image.end(), static_cast<size_t>(channels), value);
    }
  }
  return image;
}

// Depth of 1 m, of 2 m around kRay.
std::vector<uint8_t> DepthSpot(const RosInfo& info) {
  const cv::Point2d at = Project(info, kRay);
  RosWriter out;
  for (int v = 0; v < static_cast<int>(info.height); ++v) {
    for (int u = 0; u < static_cast<int>(info.width); ++u) {
      const bool near = std::hypot(u - at.x, v - at.y) < 3;
      out.Add(static_cast<uint16_t>(near ? 2000 : 1000));
    }
  }
  return out.bytes();
}

cv::Point2d CentreOf(const Image& image) {
  double sum = 0, x = 0, y = 0;
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      const double value = image.bytes.data()[v * image.width + u];
      sum += value;
      x += value * u;
      y += value * v;
    }
  }
  return {x / sum, y / sum};
}

void AddImage(TestBag& bag, const std::string& topic, const RosInfo& info, uint32_t tenth,
              bool colour) {
  bag.Add(topic + "/camera_info", "sensor_msgs/CameraInfo", info.Bytes(tenth));
  const uint32_t channels = colour ? 3 : 1;
  bag.Add(topic + "/image_raw", "sensor_msgs/Image",
          RosImage(100, tenth * 100000000, info.width, info.height, colour ? "rgb8" : "mono8",
                   info.width * channels, Spot(info, static_cast<int>(channels))));
}

// The spot is where the calibration of the log says that kRay is.
void ExpectSpot(const Image& image, const PinholeIntrinsics& k) {
  const cv::Point2d at = CentreOf(image);
  EXPECT_NEAR(at.x, k.fx * kRay.x + k.cx, 0.15);
  EXPECT_NEAR(at.y, k.fy * kRay.y + k.cy, 0.15);
}

TEST(RosbagLens, StereoOfAnyModelAndColourIsThatOfAPinhole) {
  for (const RosInfo& lens : {Rational(), Fisheye()}) {
    SCOPED_TRACE(lens.model);
    const TestFolder folder;
    TestBag bag;
    for (uint32_t i = 0; i < 3; ++i) {
      AddImage(bag, "/left", lens, i, true);
      RosInfo right = lens;
      right.baseline_m = 0.1;
      AddImage(bag, "/right", right, i, false);
    }
    bag.Write(folder.path() / "r.bag");
    const auto recording = ReadRosbag(folder.path() / "r.bag", {});
    ASSERT_TRUE(recording) << recording.error().message;
    const CameraCalibration& camera = recording->calibration.camera;
    EXPECT_FALSE(camera.left.distorted() || camera.right.distorted());
    EXPECT_NEAR(camera.T_C0C1.translation().x(), 0.1, 1e-9);
    const auto pixels = recording->frames->Load(1);
    ASSERT_TRUE(pixels) << pixels.error().message;
    ExpectSpot(pixels->left, camera.left);
    ExpectSpot(pixels->right, camera.right);
  }
}

TEST(RosbagLens, DepthIsUndistortedWithItsImage) {
  for (const RosInfo& lens : {Rational(), Fisheye()}) {
    SCOPED_TRACE(lens.model);
    const TestFolder folder;
    TestBag bag;
    for (uint32_t i = 0; i < 3; ++i) {
      AddImage(bag, "/camera/color", lens, i, true);
      bag.Add("/camera/aligned_depth_to_color/image_raw", "sensor_msgs/Image",
              RosImage(100, i * 100000000, lens.width, lens.height, "16UC1", 2 * lens.width,
                       DepthSpot(lens)));
    }
    bag.Write(folder.path() / "r.bag");
    const auto recording = ReadRosbag(folder.path() / "r.bag", {});
    ASSERT_TRUE(recording) << recording.error().message;
    const PinholeIntrinsics& k = recording->calibration.camera.left;
    const auto pixels = recording->frames->Load(1);
    ASSERT_TRUE(pixels) << pixels.error().message;
    ExpectSpot(pixels->left, k);
    const auto depth_at = [&](double u, double v) {
      const auto index = std::lround(v) * pixels->depth.width + std::lround(u);
      return reinterpret_cast<const uint16_t*>(pixels->depth.bytes.data())[index];
    };
    EXPECT_EQ(depth_at(k.fx * kRay.x + k.cx, k.fy * kRay.y + k.cy), 2000);
    EXPECT_EQ(depth_at(k.cx, k.cy), 1000);
  }
}

TEST(RosbagLens, ARightEyeOfAnotherSizeBecomesLikeTheLeft) {
  for (const bool rectified : {false, true}) {
    SCOPED_TRACE(rectified);
    const TestFolder folder;
    TestBag bag;
    RosInfo left, right;
    right.width = right.height = 96;
    right.centre_px = 47.5;
    right.focal_px = 80;
    right.baseline_m = 0.1;
    if (!rectified) right.D = {0.05, 0.01, 0.001, 0, 0};
    const std::string name = rectified ? "_rect" : "";
    for (uint32_t i = 0; i < 3; ++i) {
      for (const auto& [eye, info] : {std::pair{"/left", left}, {"/right", right}}) {
        bag.Add(std::string(eye) + "/camera_info", "sensor_msgs/CameraInfo", info.Bytes(i));
        bag.Add(std::string(eye) + "/image" + name, "sensor_msgs/Image",
                RosImage(100, i * 100000000, info.width, info.height, "mono8", info.width,
                         Spot(info, 1)));
      }
    }
    bag.Write(folder.path() / "r.bag");
    const auto recording = ReadRosbag(folder.path() / "r.bag", {});
    ASSERT_TRUE(recording) << recording.error().message;
    EXPECT_THAT(AllText(recording->warnings), HasSubstr("64 x 64, the right ones 96 x 96"));
    const CameraCalibration& camera = recording->calibration.camera;
    EXPECT_EQ(camera.right.fx, camera.left.fx);
    EXPECT_NEAR(camera.T_C0C1.translation().x(), 0.1, 1e-9);
    const auto pixels = recording->frames->Load(0);
    ASSERT_TRUE(pixels) << pixels.error().message;
    EXPECT_EQ(pixels->right.width, 64);
    ExpectSpot(pixels->left, camera.left);
    ExpectSpot(pixels->right, camera.right);
  }
}

}  // namespace
}  // namespace gw::importer

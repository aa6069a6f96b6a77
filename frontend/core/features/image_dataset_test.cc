// Features of real recordings (see the README of the shared data). Skipped where they are absent.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "frontend/core/features/feature_frame.h"
#include "frontend/core/features/stereo_rectifier.h"
#include "frontend/core/features/tum_geometry.h"

namespace gw::frontend {
namespace {

namespace fs = std::filesystem;

fs::path Recording(const std::string& name) {
  const char* shared = std::getenv("GW_SHARED_DIR");
  return fs::path(shared != nullptr ? shared : GW_SOURCE_DIR "/../shared") / "data" / name;
}

#define SKIP_WITHOUT(path) \
  if (!fs::exists(path)) GTEST_SKIP() << "no recording at " << (path) << "; set GW_SHARED_DIR"

std::vector<fs::path> Files(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

cv::Mat Read(const fs::path& file) {
  return cv::imread(file.string(), cv::IMREAD_UNCHANGED);
}

ImageView View(const cv::Mat& image) {
  return {image.data, image.cols, image.rows, static_cast<int>(image.step),
          image.elemSize() == 1 ? PixelFormat::kGray8 : PixelFormat::kDepth16};
}

double ShareWithDepth(const FeatureFrame& f) {
  const auto count = std::count_if(f.features.begin(), f.features.end(),
                                   [](const Feature& x) { return x.has_depth(); });
  return static_cast<double>(count) / static_cast<double>(f.features.size());
}

TEST(FeatureDataset, TumGivesEnoughFeaturesWithDepth) {
  const fs::path root = Recording("tum_fr1_rpy_first400");
  SKIP_WITHOUT(root);
  FeatureExtractor extractor = FeatureExtractor::Create({}, TumGeometry()).value();
  const std::vector<fs::path> gray = Files(root / "rgb"), depth = Files(root / "depth");
  for (size_t i = 0; i < std::min(gray.size(), depth.size()); i += 40) {
    const cv::Mat g = Read(gray[i]), d = Read(depth[i]);
    CameraFrame frame;
    frame.left = View(g);
    frame.depth = View(d);
    FeatureFrame out;
    ASSERT_EQ(extractor.Extract(frame, &out), FeatureExtractor::Outcome::kOk);
    EXPECT_GT(out.num_detected, 600) << gray[i];
    EXPECT_GT(ShareWithDepth(out), 0.5) << gray[i];
  }
}

// Points triangulated in one stereo pair, moved by the true motion, are found in the next.
TEST(FeatureDataset, KittiStereoPointsAreWhereTheNextPairSeesThem) {
  const fs::path root = Recording("kitti_stereo_51");
  SKIP_WITHOUT(root);
  const std::vector<fs::path> left = Files(root / "image_0"), right = Files(root / "image_1");
  std::vector<SE3> poses;
  std::ifstream file(root / "poses.txt");
  double m[12];
  const auto read_pose = [&] {
    for (double& x : m) {
      if (!(file >> x)) return false;
    }
    return true;
  };
  while (read_pose()) {
    Eigen::Matrix3d R;
    R << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
    poses.emplace_back(Eigen::Quaterniond(R), Eigen::Vector3d(m[3], m[7], m[11]));
  }
  ASSERT_EQ(poses.size(), left.size());
  const cv::Mat first = Read(left[0]);
  Calibration c;
  c.camera.kind = CameraKind::kStereo;
  c.camera.width = first.cols;
  c.camera.height = first.rows;
  c.camera.left = {.fx = 718.856, .fy = 718.856, .cx = 607.1928, .cy = 185.2157, .radtan = {}};
  c.camera.right = c.camera.left;
  c.camera.T_C0C1 = SE3(Eigen::Quaterniond::Identity(), {386.1448 / 718.856, 0, 0});
  c.camera.depth_min_m = 2;
  c.camera.depth_max_m = 500;  // of the outdoors, so that the share with depth means "matched"
  const CameraGeometry geometry = MakeCameraGeometry(c).value();
  ASSERT_FALSE(geometry.rectification.needed);
  FeatureExtractor extractor = FeatureExtractor::Create({}, geometry).value();
  const auto extract = [&](size_t i) {
    const cv::Mat l = Read(left[i]), r = Read(right[i]);
    CameraFrame frame;
    frame.left = View(l);
    frame.right = View(r);
    FeatureFrame out;
    EXPECT_EQ(extractor.Extract(frame, &out), FeatureExtractor::Outcome::kOk);
    return out;
  };
  int matches = 0;
  int close = 0;
  for (size_t i = 0; i + 1 < left.size(); i += 10) {
    const FeatureFrame a = extract(i), b = extract(i + 1);
    EXPECT_GT(a.num_detected, 600);
    EXPECT_GT(ShareWithDepth(a), 0.4);
    const SE3 T_BA = poses[i + 1].inverse() * poses[i];
    for (size_t p = 0; p < a.features.size(); ++p) {
      const Feature& f = a.features[p];
      if (!f.has_depth() || f.depth > 40) continue;  // 40 m: 10 px of disparity
      const Eigen::Vector3d point = T_BA * geometry.rectified.Unproject(f.u, f.v, f.depth);
      if (point.z() < 2) continue;
      const Eigen::Vector2d uv = geometry.rectified.Project(point);
      int best = 50;
      double error = -1;
      for (size_t q = 0; q < b.features.size(); ++q) {
        const Feature& g = b.features[q];
        const double distance = (uv - Eigen::Vector2d(g.u, g.v)).norm();
        const int hamming = HammingDistance(a.descriptors[p], b.descriptors[q]);
        if (distance > 30 || hamming >= best) continue;
        best = hamming;
        error = distance / std::pow(1.2, g.level);
      }
      if (error < 0) continue;
      ++matches;
      close += error < 3;
    }
  }
  EXPECT_GT(matches, 400);
  EXPECT_GT(close, 0.85 * matches);
}

// The two eyes stand still and look at one scene: rectified, a point has the same row in both, and
// all frames give the same depths.
TEST(FeatureDataset, EurocRectifiesToEqualRows) {
  const fs::path root = Recording("euroc_v101_static");
  SKIP_WITHOUT(root);
  const auto matrix = [](std::initializer_list<double> v) {
    Eigen::Matrix4d m;
    std::copy(v.begin(), v.end(), m.data());
    m.transposeInPlace();
    return SE3(Eigen::Quaterniond(Eigen::Matrix3d(m.topLeftCorner<3, 3>())),
               m.topRightCorner<3, 1>());
  };
  const SE3 T_BC0 =
      matrix({0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975, 0.999557249008,
              0.0149672133247, 0.025715529948, -0.064676986768, -0.0257744366974, 0.00375618835797,
              0.999660727178, 0.00981073058949, 0, 0, 0, 1});
  const SE3 T_BC1 =
      matrix({0.0125552670891, -0.999755099723, 0.0182237714554, -0.0198435579556, 0.999598781151,
              0.0130119051815, 0.0251588363115, 0.0453689425024, -0.0253898008918, 0.0179005838253,
              0.999517347078, 0.00786212447038, 0, 0, 0, 1});
  Calibration c;
  c.camera.kind = CameraKind::kStereo;
  c.camera.width = 752;
  c.camera.height = 480;
  c.camera.left = {.fx = 458.654,
                   .fy = 457.296,
                   .cx = 367.215,
                   .cy = 248.375,
                   .radtan = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0}};
  c.camera.right = {.fx = 457.587,
                    .fy = 456.134,
                    .cx = 379.999,
                    .cy = 255.238,
                    .radtan = {-0.28368365, 0.07451284, -0.00010473, -3.55590700e-05, 0}};
  c.camera.T_C0C1 = T_BC0.inverse() * T_BC1;
  c.camera.depth_max_m = 15;
  const CameraGeometry geometry = MakeCameraGeometry(c).value();
  ASSERT_TRUE(geometry.rectification.needed);
  const std::vector<fs::path> left = Files(root / "mav0/cam0/data");
  const std::vector<fs::path> right = Files(root / "mav0/cam1/data");
  const cv::Mat l = Read(left[0]), r = Read(right[0]);

  // Same rows: features matched by descriptor anywhere near, also off the row.
  const StereoRectifier left_rectifier(geometry, Eye::kLeft),
      right_rectifier(geometry, Eye::kRight);
  ImageBuffer l_rectified, r_rectified;
  left_rectifier.Rectify(View(l), &l_rectified);
  right_rectifier.Rectify(View(r), &r_rectified);
  Calibration mono = c;
  mono.camera.kind = CameraKind::kRgbd;
  mono.camera.left.radtan = {};
  FeatureExtractor plain = FeatureExtractor::Create({}, MakeCameraGeometry(mono).value()).value();
  FeatureFrame a, b;
  CameraFrame frame;
  frame.left = l_rectified.View();
  plain.Extract(frame, &a);
  frame.left = r_rectified.View();
  plain.Extract(frame, &b);
  std::vector<double> row_differences;
  for (size_t i = 0; i < a.features.size(); ++i) {
    int best = 40;
    double difference = 0;
    for (size_t j = 0; j < b.features.size(); ++j) {
      const double dv = b.features[j].v - a.features[i].v;
      const double du = a.features[i].u - b.features[j].u;
      const int hamming = HammingDistance(a.descriptors[i], b.descriptors[j]);
      if (a.features[i].level > 1 || b.features[j].level > 1 || std::abs(dv) > 12 || du < -3 ||
          du > 120 || hamming >= best) {
        continue;
      }
      best = hamming;
      difference = dv;
    }
    if (best < 40) row_differences.push_back(difference);
  }
  ASSERT_GT(row_differences.size(), 30u);
  std::sort(row_differences.begin(), row_differences.end());
  EXPECT_NEAR(row_differences[row_differences.size() / 2], 0, 0.5);

  FeatureExtractor extractor = FeatureExtractor::Create({}, geometry).value();
  for (size_t i = 0; i < std::min(left.size(), right.size()); i += 10) {
    const cv::Mat left_image = Read(left[i]), right_image = Read(right[i]);
    frame.left = View(left_image);
    frame.right = View(right_image);
    FeatureFrame out;
    ASSERT_EQ(extractor.Extract(frame, &out), FeatureExtractor::Outcome::kOk);
    EXPECT_GT(out.num_detected, 600);
    EXPECT_GT(ShareWithDepth(out), 0.3);
  }
}

}  // namespace
}  // namespace gw::frontend

// Cost of feature extraction and of its parts, as a ratio to what OpenCV has for the same work, on
// the same images in the same run: the ratio carries over between machines, milliseconds do not.
// One thread; CPU time of the thread, so that other load counts little. Quality: feature_study.
//
// Images: GW_SHARED_DIR/tum_fr1_rpy_first400 when there (with depth), else a rendered texture.
#include <benchmark/benchmark.h>
#include <time.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "frontend/core/features/feature_frame.h"
#include "frontend/core/features/image_pyramid.h"
#include "frontend/core/features/image_test_pattern.h"
#include "frontend/core/features/orb_detector.h"
#include "frontend/core/features/stereo_rectifier.h"
#include "frontend/core/features/tum_geometry.h"

namespace gw::frontend {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;

struct Image {
  cv::Mat gray, depth;
};

std::vector<std::filesystem::path> Files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<Image> LoadImages() {
  const char* shared = std::getenv("GW_SHARED_DIR");
  const std::filesystem::path root =
      std::filesystem::path(shared != nullptr ? shared : GW_SOURCE_DIR "/../shared") / "data" /
      "tum_fr1_rpy_first400";
  const std::vector<std::filesystem::path> gray = Files(root / "rgb"),
                                           depth = Files(root / "depth");
  std::vector<Image> images;
  constexpr size_t kStep = 4;
  for (size_t i = 0; i < std::min(gray.size(), depth.size()); i += kStep) {
    images.push_back({cv::imread(gray[i].string(), cv::IMREAD_GRAYSCALE),
                      cv::imread(depth[i].string(), cv::IMREAD_UNCHANGED)});
  }
  if (!images.empty()) return images;
  for (uint64_t seed = 0; seed < 10; ++seed) {
    const ImageBuffer rendered = Render(
        CellTexture(seed, 10), kWidth, kHeight,
        [](double u, double v) { return Eigen::Vector2d(u, v); }, 2, seed);
    images.push_back(
        {cv::Mat(kHeight, kWidth, CV_8UC1, const_cast<uint8_t*>(rendered.row(0))).clone(),
         cv::Mat(kHeight, kWidth, CV_16UC1, cv::Scalar(10000))});
  }
  return images;
}

double ThreadCpuMs() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double Percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))];
}

// Medians and 99th percentiles of two ways to do the same, in turn.
class Comparison {
 public:
  template <typename Ours, typename Theirs>
  void Run(const Ours& ours, const Theirs& theirs) {
    const double begin = ThreadCpuMs();
    ours();
    const double middle = ThreadCpuMs();
    theirs();
    const double end = ThreadCpuMs();
    ours_.push_back(middle - begin);
    theirs_.push_back(end - middle);
  }

  void Report(benchmark::State& state) const {
    state.counters["ours_ms"] = Percentile(ours_, 0.5);
    state.counters["ours_p99_ms"] = Percentile(ours_, 0.99);
    state.counters["opencv_ms"] = Percentile(theirs_, 0.5);
    state.counters["opencv_p99_ms"] = Percentile(theirs_, 0.99);
    state.counters["ratio"] = Percentile(ours_, 0.5) / Percentile(theirs_, 0.5);
  }

 private:
  std::vector<double> ours_, theirs_;
};

ImageView ViewOf(const cv::Mat& image) {
  return {image.data, image.cols, image.rows, static_cast<int>(image.step), PixelFormat::kGray8};
}

cv::Mat MatOf(const ImageBuffer& image) {
  return {image.height, image.width, CV_8UC1, const_cast<uint8_t*>(image.row(0)),
          static_cast<size_t>(image.stride)};
}

void ExtractRgbdAgainstOpenCvOrb(benchmark::State& state) {
  cv::setNumThreads(1);
  const std::vector<Image> images = LoadImages();
  FeatureExtractor extractor = FeatureExtractor::Create({}, TumGeometry()).value();
  const cv::Ptr<cv::ORB> orb = cv::ORB::create(800, 1.2f, 8);
  FeatureFrame out;
  Comparison comparison;
  for (auto _ : state) {
    for (const Image& image : images) {
      CameraFrame frame;
      frame.left = ViewOf(image.gray);
      frame.depth = {image.depth.data, kWidth, kHeight, static_cast<int>(image.depth.step),
                     PixelFormat::kDepth16};
      std::vector<cv::KeyPoint> keypoints;
      cv::Mat descriptors;
      comparison.Run(
          [&] { benchmark::DoNotOptimize(extractor.Extract(frame, &out)); },
          [&] { orb->detectAndCompute(image.gray, cv::noArray(), keypoints, descriptors); });
    }
  }
  comparison.Report(state);
}
BENCHMARK(ExtractRgbdAgainstOpenCvOrb)->Unit(benchmark::kMillisecond);

// The pyramid of image_pyramid.h, and the same filters of OpenCV: the binomial kernel is what
// GaussianBlur takes for 3x3 and a sigma of its own choice.
void PyramidAgainstOpenCv(benchmark::State& state) {
  cv::setNumThreads(1);
  const std::vector<Image> images = LoadImages();
  ImagePyramid pyramid(kWidth, kHeight, 8, 1.2, 33);
  std::vector<cv::Mat> levels(8);
  Comparison comparison;
  for (auto _ : state) {
    for (const Image& image : images) {
      comparison.Run([&] { pyramid.Build(ViewOf(image.gray)); },
                     [&] {
                       cv::Mat once;
                       cv::GaussianBlur(image.gray, once, {3, 3}, 0);
                       cv::GaussianBlur(once, levels[0], {3, 3}, 0);
                       for (int l = 1; l < 8; ++l) {
                         const ImageBuffer& size = pyramid.level(l);
                         cv::resize(levels[static_cast<size_t>(l - 1)], once,
                                    {size.width, size.height}, 0, 0, cv::INTER_LINEAR);
                         cv::GaussianBlur(once, levels[static_cast<size_t>(l)], {3, 3}, 0);
                       }
                     });
    }
  }
  comparison.Report(state);
}
BENCHMARK(PyramidAgainstOpenCv)->Unit(benchmark::kMillisecond);

// Corners of all levels at the low threshold: of the detector, which asks for it only in cells that
// have few strong ones, and of cv::FAST, which has one threshold for the whole image.
void CornersAgainstOpenCvFast(benchmark::State& state) {
  cv::setNumThreads(1);
  const std::vector<Image> images = LoadImages();
  const OrbConfig config;
  ImagePyramid pyramid(kWidth, kHeight, 8, 1.2, 33);
  OrbDetector detector(config.fast_threshold, config.fast_threshold_low, 16);
  std::vector<Corner> corners;
  std::vector<cv::KeyPoint> keypoints;
  size_t num_ours = 0, num_theirs = 0;
  Comparison comparison;
  for (auto _ : state) {
    for (const Image& image : images) {
      pyramid.Build(ViewOf(image.gray));
      comparison.Run(
          [&] {
            for (int l = 0; l < pyramid.num_levels(); ++l) {
              detector.Detect(pyramid.level(l), &corners);
              num_ours += corners.size();
            }
          },
          [&] {
            for (int l = 0; l < pyramid.num_levels(); ++l) {
              cv::FAST(MatOf(pyramid.level(l)), keypoints, config.fast_threshold_low);
              num_theirs += keypoints.size();
            }
          });
    }
  }
  comparison.Report(state);
  state.counters["corners_ratio"] = static_cast<double>(num_ours) / static_cast<double>(num_theirs);
}
BENCHMARK(CornersAgainstOpenCvFast)->Unit(benchmark::kMillisecond);

// A stereo camera with the lens of EuRoC's MAV, its right eye a little askew.
CameraGeometry Askew() {
  Calibration c;
  c.camera.kind = CameraKind::kStereo;
  c.camera.width = kWidth;
  c.camera.height = kHeight;
  c.camera.left = {.fx = 390,
                   .fy = 390,
                   .cx = 320,
                   .cy = 240,
                   .radtan = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0}};
  c.camera.right = c.camera.left;
  c.camera.T_C0C1 = SE3(ExpSO3({0.01, -0.005, 0.008}), {0.11, 0.001, 0.001});
  return MakeCameraGeometry(c).value();
}

// The rectifier, and cv::remap with the same map in its fastest form (fixed point).
void RectifierAgainstOpenCvRemap(benchmark::State& state) {
  cv::setNumThreads(1);
  const std::vector<Image> images = LoadImages();
  const CameraGeometry geometry = Askew();
  const StereoRectifier rectifier(geometry, Eye::kLeft);
  cv::Mat x(kHeight, kWidth, CV_32FC1), y(kHeight, kWidth, CV_32FC1), whole, fraction, theirs;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const Eigen::Vector2d pixel =
          RectifiedToSource(geometry.rectified, geometry.calibration.camera.left,
                            geometry.rectification.R_C0Rect, Eigen::Vector2d(u, v));
      x.at<float>(v, u) = static_cast<float>(pixel.x());
      y.at<float>(v, u) = static_cast<float>(pixel.y());
    }
  }
  cv::convertMaps(x, y, whole, fraction, CV_16SC2);
  ImageBuffer ours;
  Comparison comparison;
  for (auto _ : state) {
    for (const Image& image : images) {
      comparison.Run([&] { rectifier.Rectify(ViewOf(image.gray), &ours); },
                     [&] { cv::remap(image.gray, theirs, whole, fraction, cv::INTER_LINEAR); });
    }
  }
  comparison.Report(state);
  const cv::Mat both_valid = MatOf(rectifier.valid()) > 1;
  cv::Mat difference;
  cv::absdiff(MatOf(ours), theirs, difference);
  double most = 0;
  cv::minMaxLoc(difference, nullptr, &most, nullptr, nullptr, both_valid);
  state.counters["largest_difference"] = most;
}
BENCHMARK(RectifierAgainstOpenCvRemap)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gw::frontend

BENCHMARK_MAIN();

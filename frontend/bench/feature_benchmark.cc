// Cost of feature extraction, as a ratio to cv::ORB (800 features, 8 levels) on the same images in
// the same run: the ratio carries over between machines, milliseconds do not. One thread; CPU time
// of the thread, so that other load counts little.
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
#include <string>
#include <vector>

#include "frontend/core/features/feature_frame.h"
#include "frontend/core/features/image_test_pattern.h"
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

void ExtractRgbdAgainstOpenCvOrb(benchmark::State& state) {
  cv::setNumThreads(1);
  const std::vector<Image> images = LoadImages();
  FeatureExtractor extractor = FeatureExtractor::Create({}, TumGeometry()).value();
  const cv::Ptr<cv::ORB> orb = cv::ORB::create(800, 1.2f, 8);
  FeatureFrame out;
  std::vector<double> ours, theirs;
  for (auto _ : state) {
    for (const Image& image : images) {
      CameraFrame frame;
      frame.left = {image.gray.data, kWidth, kHeight, static_cast<int>(image.gray.step),
                    PixelFormat::kGray8};
      frame.depth = {image.depth.data, kWidth, kHeight, static_cast<int>(image.depth.step),
                     PixelFormat::kDepth16};
      const double begin = ThreadCpuMs();
      benchmark::DoNotOptimize(extractor.Extract(frame, &out));
      const double middle = ThreadCpuMs();
      std::vector<cv::KeyPoint> keypoints;
      cv::Mat descriptors;
      orb->detectAndCompute(image.gray, cv::noArray(), keypoints, descriptors);
      const double end = ThreadCpuMs();
      ours.push_back(middle - begin);
      theirs.push_back(end - middle);
    }
  }
  state.counters["ours_ms"] = Percentile(ours, 0.5);
  state.counters["ours_p99_ms"] = Percentile(ours, 0.99);
  state.counters["orb_ms"] = Percentile(theirs, 0.5);
  state.counters["orb_p99_ms"] = Percentile(theirs, 0.99);
  state.counters["ratio"] = Percentile(ours, 0.5) / Percentile(theirs, 0.5);
}
BENCHMARK(ExtractRgbdAgainstOpenCvOrb)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gw::frontend

BENCHMARK_MAIN();

// Cost of the whole frame path, features to pose, as a ratio to cv::ORB::detectAndCompute (800
// features, 8 levels) on the same images in the same run, one thread.
//
// Images: GW_SHARED_DIR/tum_fr1_rpy_first400, in order, with the map growing as it does live but
// without a back-end; skips when the recording is absent.
#include <benchmark/benchmark.h>
#include <time.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "frontend/core/tracking/tracker.h"

namespace gw::frontend {
namespace {

double ThreadSeconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::vector<cv::Mat> Load(const std::filesystem::path& folder, int flags) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<cv::Mat> images;
  for (const auto& file : files) images.push_back(cv::imread(file.string(), flags));
  return images;
}

double Quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(q * static_cast<double>(values.size() - 1))];
}

CameraGeometry Freiburg1() {
  Calibration c;
  c.camera.kind = CameraKind::kRgbd;
  c.camera.width = 640;
  c.camera.height = 480;
  c.camera.left = {517.3, 516.5, 318.6, 255.3, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}};
  c.camera.depth_unit_m = 0.0002;
  c.camera.readout_s = 0.026;
  return *MakeCameraGeometry(c);
}

void TrackingAgainstCvOrb(benchmark::State& state) {
  const char* shared = std::getenv("GW_SHARED_DIR");
  const std::filesystem::path root =
      std::filesystem::path(shared != nullptr ? shared : GW_SOURCE_DIR "/../shared") / "data" /
      "tum_fr1_rpy_first400";
  const auto gray = Load(root / "rgb", cv::IMREAD_GRAYSCALE);
  const auto depth = Load(root / "depth", cv::IMREAD_UNCHANGED);
  if (gray.empty() || depth.empty()) {
    state.SkipWithError("no recording at GW_SHARED_DIR/tum_fr1_rpy_first400");
    return;
  }
  cv::setNumThreads(1);
  const auto orb = cv::ORB::create(800, 1.2F, 8);
  std::vector<double> ours, theirs;
  for (auto _ : state) {
    FrontendConfig config;
    config.variant = Variant::kNone;
    Tracker tracker = *Tracker::Create(config, Freiburg1());
    MapUpdate empty;
    empty.snapshot = true;
    tracker.Push(empty);
    for (size_t i = 0; i < std::min(gray.size(), depth.size()); ++i) {
      CameraFrame frame;
      frame.utime = {static_cast<int64_t>(i) * 33333};
      frame.seq = static_cast<int64_t>(i) + 1;
      frame.left = {gray[i].data, gray[i].cols, gray[i].rows, static_cast<int>(gray[i].step),
                    PixelFormat::kGray8};
      frame.depth = {depth[i].data, depth[i].cols, depth[i].rows, static_cast<int>(depth[i].step),
                     PixelFormat::kDepth16};
      double start = ThreadSeconds();
      benchmark::DoNotOptimize(tracker.Push(frame));
      ours.push_back(ThreadSeconds() - start);
      std::vector<cv::KeyPoint> keypoints;
      cv::Mat descriptors;
      start = ThreadSeconds();
      orb->detectAndCompute(gray[i], {}, keypoints, descriptors);
      theirs.push_back(ThreadSeconds() - start);
    }
  }
  state.counters["ours_median_ms"] = 1e3 * Quantile(ours, 0.5);
  state.counters["ours_p99_ms"] = 1e3 * Quantile(ours, 0.99);
  state.counters["cv_orb_median_ms"] = 1e3 * Quantile(theirs, 0.5);
  state.counters["ratio_median"] = Quantile(ours, 0.5) / Quantile(theirs, 0.5);
  state.counters["p99_over_median"] = Quantile(ours, 0.99) / Quantile(ours, 0.5);
}
BENCHMARK(TrackingAgainstCvOrb)->Unit(benchmark::kSecond)->Iterations(2);

}  // namespace
}  // namespace gw::frontend

BENCHMARK_MAIN();

// Cost of the whole frame path, features to pose, as a ratio to cv::ORB::detectAndCompute (800
// features, 8 levels) on the same images in the same run, one thread.
//
// Images: GW_SHARED_DIR/tum_fr1_rpy_first400, in order, with the map growing as it does live but
// without a back-end; skips when the recording is absent.
//
// And the part from features to pose alone, by how landmarks are chosen (`frontend.matching`), with
// 800 and 2000 features.
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

// The images of the recording; empty when it is absent.
struct Recording {
  std::vector<cv::Mat> gray, depth;

  size_t size() const { return std::min(gray.size(), depth.size()); }
  CameraFrame Frame(size_t i) const {
    CameraFrame frame;
    frame.utime = {static_cast<int64_t>(i) * 33333};
    frame.seq = static_cast<int64_t>(i) + 1;
    frame.left = {gray[i].data, gray[i].cols, gray[i].rows, static_cast<int>(gray[i].step),
                  PixelFormat::kGray8};
    frame.depth = {depth[i].data, depth[i].cols, depth[i].rows, static_cast<int>(depth[i].step),
                   PixelFormat::kDepth16};
    return frame;
  }
};

Recording LoadRecording() {
  const char* shared = std::getenv("GW_SHARED_DIR");
  const std::filesystem::path root =
      std::filesystem::path(shared != nullptr ? shared : GW_SOURCE_DIR "/../shared") / "data" /
      "tum_fr1_rpy_first400";
  return {Load(root / "rgb", cv::IMREAD_GRAYSCALE), Load(root / "depth", cv::IMREAD_UNCHANGED)};
}

void TrackingAgainstCvOrb(benchmark::State& state) {
  const Recording recording = LoadRecording();
  if (recording.gray.empty() || recording.depth.empty()) {
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
    for (size_t i = 0; i < recording.size(); ++i) {
      const CameraFrame frame = recording.Frame(i);
      double start = ThreadSeconds();
      benchmark::DoNotOptimize(tracker.Push(frame));
      ours.push_back(ThreadSeconds() - start);
      std::vector<cv::KeyPoint> keypoints;
      cv::Mat descriptors;
      start = ThreadSeconds();
      orb->detectAndCompute(recording.gray[i], {}, keypoints, descriptors);
      theirs.push_back(ThreadSeconds() - start);
    }
  }
  state.counters["ours_median_ms"] = 1e3 * Quantile(ours, 0.5);
  state.counters["ours_p99_ms"] = 1e3 * Quantile(ours, 0.99);
  state.counters["cv_orb_median_ms"] = 1e3 * Quantile(theirs, 0.5);
  state.counters["ratio_median"] = Quantile(ours, 0.5) / Quantile(theirs, 0.5);
  state.counters["p99_over_median"] = Quantile(ours, 0.99) / Quantile(ours, 0.5);
}
// Arguments: Matching, features per image.
void FeaturesToPose(benchmark::State& state) {
  const Recording recording = LoadRecording();
  if (recording.gray.empty() || recording.depth.empty()) {
    state.SkipWithError("no recording at GW_SHARED_DIR/tum_fr1_rpy_first400");
    return;
  }
  FrontendConfig config;
  config.variant = Variant::kNone;
  config.matching = static_cast<Matching>(state.range(0));
  config.orb.num_features = static_cast<int>(state.range(1));
  FeatureExtractor extractor = *FeatureExtractor::Create(config.orb, Freiburg1());
  std::vector<double> seconds, inliers;
  for (auto _ : state) {
    Tracker tracker = *Tracker::Create(config, Freiburg1());
    MapUpdate empty;
    empty.snapshot = true;
    tracker.Push(empty);
    FeatureFrame features;
    for (size_t i = 0; i < recording.size(); ++i) {
      const CameraFrame frame = recording.Frame(i);
      extractor.Extract(frame, &features);
      const double start = ThreadSeconds();
      const TrackerOutput out = tracker.Track(frame.utime, frame.seq, features);
      const double spent = ThreadSeconds() - start;
      if (!out.keyframe) seconds.push_back(spent);
      inliers.push_back(out.pose.num_inliers);
    }
  }
  state.counters["median_ms"] = 1e3 * Quantile(seconds, 0.5);
  state.counters["p99_ms"] = 1e3 * Quantile(seconds, 0.99);
  state.counters["median_inliers"] = Quantile(inliers, 0.5);
}
BENCHMARK(FeaturesToPose)
    ->ArgNames({"matching", "features"})
    ->ArgsProduct({{0, 1, 2}, {800, 2000}})
    ->Unit(benchmark::kSecond)
    ->Iterations(1);

BENCHMARK(TrackingAgainstCvOrb)->Unit(benchmark::kSecond)->Iterations(2);

}  // namespace
}  // namespace gw::frontend

BENCHMARK_MAIN();

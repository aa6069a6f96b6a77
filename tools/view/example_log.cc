// Writes a log of 33 s for the tests of the page: a robot goes round a circle, sees, is blind, sees
// again, and closes a loop; in the last three seconds no images come any more. Made up, and always
// the same; every channel that gw-view shows is in it. usage: gw-view-example-log OUT.lcm
#include <cmath>
#include <cstdio>
#include <numbers>

#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/frame_detail.h"
#include "common/wire/wire.h"

namespace gw::view {
namespace {

constexpr int kImages = 300, kSteps = 330;  // at 10 Hz
constexpr int kWidth = 320, kHeight = 240;
constexpr int kBlindFrom = 120, kBlindTo = 160;
constexpr Utime kStart{1'700'000'000'000'000};

SE3 Planar(double x, double y, double yaw) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())), {x, y, 0}};
}

// On a circle of 2 m radius, once round.
SE3 BodyAt(double fraction) {
  const double angle = 2 * std::numbers::pi * fraction;
  return Planar(2 * std::sin(angle), 2 - 2 * std::cos(angle), angle);
}

bool Blind(int i) {
  return i >= kBlindFrom && i < kBlindTo;
}

class Writer {
 public:
  explicit Writer(process::EventLogWriter& log) : log_(log) {}

  void Image(int i) {
    pixels_.resize(static_cast<size_t>(kWidth) * kHeight);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool light = ((x + 3 * i) / 24 + y / 24) % 2 == 0;
        pixels_[static_cast<size_t>(y) * kWidth + x] = Blind(i) ? 12 : light ? 190 : 70;
      }
    }
    CameraFrame frame;
    frame.utime = At(i);
    frame.seq = i + 1;
    frame.left = {pixels_.data(), kWidth, kHeight, kWidth, PixelFormat::kGray8};
    frame.right = frame.left;
    Put(wire::kCamera, frame);
  }

  void Tracking(int i) {
    FrameDetail detail;
    detail.utime = At(i);
    detail.seq = i + 1;
    detail.bound = Blind(i) ? AlphaBound::kAlphaMax : AlphaBound::kAlphaMin;
    detail.alpha_translation = detail.alpha_rotation = Blind(i) ? 10 : 0.01;
    detail.dr_share.setConstant(Blind(i) ? 1.0 : 0.05);
    for (int k = 0; k < (Blind(i) ? 5 : 200); ++k) {
      detail.features.push_back(
          {static_cast<float>(k * 37 % kWidth), static_cast<float>(k * 53 % kHeight),
           Blind(i) ? FeatureFate::kUnmatched : static_cast<FeatureFate>(k % 4)});
    }
    Put(wire::kFrameDetail, detail);
    FramePose pose;
    pose.utime = At(i);
    pose.seq = i + 1;
    pose.T_WB = BodyAt(static_cast<double>(i) / kImages);
    pose.cov_T_WB = Matrix6d::Identity() * 1e-4;
    pose.status = Blind(i) ? TrackingStatus::kDrOnly : TrackingStatus::kTracking;
    pose.reason = Blind(i) ? TrackingReason::kTooFewFeatures : TrackingReason::kNone;
    pose.num_detected = static_cast<int>(detail.features.size());
    pose.num_inliers = Blind(i) ? 0 : 150;
    pose.q = Blind(i) ? 0.05 : 0.97;
    pose.alpha = detail.alpha_rotation;
    pose.dr_share = Blind(i) ? 1 : 0.05;
    pose.latency_us = 4000 + 100 * (i % 7);
    Put(wire::kFramePose, pose);
  }

  void DeadReckoning(int i) {
    DrState state;
    state.utime = At(i);
    state.seq = i + 1;
    state.T_OB =
        Planar(0.05 * i / kImages, 0.1 * i / kImages, 0) * BodyAt(static_cast<double>(i) / kImages);
    state.wheels_alive = state.imu_alive = true;
    Put(wire::kDr, state);
    Pose pose;
    pose.utime = At(i);
    pose.seq = i + 1;
    pose.T_WB = BodyAt(static_cast<double>(i) / kImages);
    pose.T_WO = pose.T_WB * state.T_OB.inverse();
    pose.has_map = true;
    Put(wire::kPose, pose);
    GroundTruth truth;
    truth.utime = At(i);
    truth.seq = i + 1;
    truth.T_GB = Planar(1, 2, 0.5) * pose.T_WB;
    Put(wire::kGroundTruth, truth);
  }

  void Map(int i) {
    MapUpdate update;
    update.utime = At(i);
    update.revision = ++revision_;
    update.base_revision = revision_ - 1;
    update.snapshot = revision_ == 1;
    if (update.snapshot) update.base_revision = 0;
    const KeyframeId id{revision_};
    update.newest_keyframe = id;
    update.keyframes = {{id, At(i), BodyAt(static_cast<double>(i) / kImages)}};
    for (int k = 0; k < 40; ++k) {
      LandmarkUpdate landmark;
      landmark.id = LandmarkId::From(id, k);
      const double angle = 0.157 * k + 0.1 * i;
      landmark.p_W = {4 * std::cos(angle), 2 + 4 * std::sin(angle), 0.05 * k};
      landmark.normal_W = Eigen::Vector3d::UnitX();
      landmark.max_distance = 5;
      landmark.observations = {{id, k}};
      update.landmarks.push_back(landmark);
    }
    if (i >= kImages - 10) update.loops = {{id, KeyframeId{1}, true, Planar(0.05, 0.1, 0)}};
    Put(wire::kMapUpdate, update);
  }

  void Health(int i, const std::string& process, HealthState state, const std::string& message) {
    gw::Health health;
    health.utime = At(i);
    health.seq = i + 1;
    health.process = process;
    health.state = state;
    health.message = message;
    health.counters = {{"CAMERA.lost", i < 250 ? 0 : i / 10}};
    health.latency_p99_us = 7100;
    health.version = "example";
    Put(wire::kHealth, health);
  }

  void Step(int i) {
    DeadReckoning(i);
    if (i < kImages) {
      Image(i);
      Tracking(i);
    }
    if (i % 10 != 0) return;
    if (i < kImages) Map(i);
    const char* dark = "vision sees nothing, dead reckoning carries the pose: check lens and light";
    Health(i, "gw-frontend", Blind(i) ? HealthState::kDegraded : HealthState::kOk,
           Blind(i) ? dark : "");
    if (i < 200) Health(i, "gw-backend", HealthState::kOk, "");
  }

 private:
  static Utime At(int i) { return kStart + Milliseconds(100 * i); }
  template <typename T>
  void Put(const char* channel, const T& message) {
    auto bytes = wire::Encode(message);
    if (log_.Append(message.utime, channel, bytes).ok()) return;
    std::fprintf(stderr, "%s cannot be written\n", channel);
  }

  process::EventLogWriter& log_;
  std::vector<uint8_t> pixels_;
  int64_t revision_ = 0;
};

int Main(int argc, char** argv) {
  if (argc != 2) return 2;
  auto log = process::EventLogWriter::Create(argv[1]);
  if (!log) return 1;
  Writer writer(*log);
  for (int i = 0; i < kSteps; ++i) writer.Step(i);
  return log->Close().ok() ? 0 : 1;
}

}  // namespace
}  // namespace gw::view

int main(int argc, char** argv) {
  return gw::view::Main(argc, argv);
}

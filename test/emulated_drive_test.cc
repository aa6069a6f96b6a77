// The whole robot without hardware, in virtual time: an emulated D435i looks into a rendered room
// from an emulated Kobuki; both speak their own protocols to the drivers; what the drivers publish
// goes through dead reckoning, front-end and back-end, and the robot is driven by the poses that
// come out. (The base's serial port is tested in drivers/kobuki/device and test/robot.)
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/process/bus.h"
#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "drivers/camera/device/camera_node.h"
#include "drivers/kobuki/core/driver.h"
#include "test/emulators/camera/emulated_camera.h"
#include "test/emulators/camera/fake_system.h"
#include "test/emulators/kobuki/emulator.h"
#include "tools/lab/slam/slam_session.h"
#include "tools/robot/floorplan/planner.h"
#include "tools/robot/floorplan/test_room.h"
#include "tools/sim/sim/camera_sensor.h"
#include "tools/sim/sim/path_follower.h"
#include "tools/sim/sim/renderer.h"

namespace gw {
namespace {

constexpr int64_t kStartUs = 1'000'000;  // CLOCK_MONOTONIC
constexpr int64_t kOffsetUs = 1'700'000'000'000'000;
constexpr double kTransportDelayS = 0.047;  // delay of the base, see RobotForTest
const sim::Pinhole kPinhole{424, 240, 255, 255, 211.5, 119.5};

RobotConfig RobotForTest() {
  RobotConfig config;
  config.robot.name = "emulated";
  CameraCalibration& camera = config.calibration.camera;
  camera.kind = CameraKind::kStereo;
  camera.width = kPinhole.width;
  camera.height = kPinhole.height;
  camera.rate_hz = 15;
  camera.left = {kPinhole.fx, kPinhole.fy, kPinhole.cx, kPinhole.cy, {}};
  camera.right = camera.left;
  camera.T_C0C1 = SE3(Eigen::Quaterniond::Identity(), {0.05, 0, 0});
  camera.T_BC = SE3(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0.1, 0.0175, 0.25});
  ImuCalibration& imu = config.calibration.imu;  // the IMU is the base's gyro
  imu.present = true;
  imu.has_accel = false;
  imu.rate_hz = 100;
  imu.time_offset_s = kTransportDelayS;
  config.calibration.wheel.present = true;
  config.calibration.wheel.time_offset_s = kTransportDelayS;
  config.drivers.camera.publish_imu = false;
  config.drivers.camera.transport_delay_ms = 5;  // the delay of the emulator
  config.drivers.kobuki.publish_imu = true;
  return config;
}

camera::EmulatedCameraConfig CameraForTest(const camera::FakeSystem& system) {
  camera::EmulatedCameraConfig config;
  config.dev = system.roots().dev;
  config.width = kPinhole.width;
  config.height = kPinhole.height;
  config.rate_hz = 15;
  config.start_us = kStartUs;
  config.first_pts_us = UINT32_MAX - 8'000'000;  // the camera's clock wraps on the way
  config.clock_ppm = 40;
  return config;
}

kobuki::EmulatorConfig BaseForTest() {
  kobuki::EmulatorConfig config;
  config.start = Utime{kStartUs + kOffsetUs};
  config.first_timestamp_ms = 60'000;  // the base's clock and counters wrap on the way
  config.first_left_ticks = 65'000;
  config.latency_timer = Milliseconds(16);
  config.transport_delay = DurationFromSeconds(kTransportDelayS);
  config.clock_ppm = -30;
  return config;
}

class EmulatedRobot {
 public:
  EmulatedRobot(std::vector<floorplan::Waypoint> stops, const std::vector<floorplan::Leg>& legs)
      : config_(RobotForTest()),
        start_(stops.front()),
        world_(floorplan::RoomForTest(), {}, start_.position, KeepFree(stops, legs), 7),
        renderer_(world_, kPinhole, &pool_),
        left_eye_(kPinhole, {}, &pool_),
        right_eye_(kPinhole, {}, &pool_),
        follower_(std::move(stops), legs, {}),
        system_(std::filesystem::temp_directory_path() /
                ("emulated_drive_" + std::to_string(::getpid()))),
        camera_(CameraForTest(system_), [this](int64_t frame, bool) { return See(frame); }),
        camera_node_(config_, &bus_,
                     {.calls = &camera_,
                      .roots = system_.roots(),
                      .now = [this] { return now(); },
                      .monotonic_offset = {kOffsetUs},
                      .reset_usb = [](int, int) -> Result<Done> { return Done{}; }},
                     process::LogLine(Milliseconds(0), [](const std::string&) {})),
        base_(BaseForTest()),
        driver_(config_.drivers.kobuki, config_.calibration.wheel),
        session_(tools::SlamSession::Create(config_).value()) {
    system_.Plug({.port = "2-1"});
    driver_.PortOpened(now());
    for (const char* channel : {wire::kCamera, wire::kImu, wire::kWheel}) {
      EXPECT_TRUE(bus_.Subscribe(
          channel, [this, channel](std::span<const uint8_t> message, Utime received) {
            session_.Process({++messages_[channel], received, channel, message});
          }));
    }
    EXPECT_TRUE(bus_.Subscribe(wire::kHealth, [this](std::span<const uint8_t> message, Utime) {
      camera_health_ = wire::Decode<Health>(message).value();
    }));
  }

  // Simulates one millisecond.
  void Step() {
    now_us_ += 1000;
    bus_.set_now(now());
    for (const auto& delivery : base_.AdvanceTo(now())) {
      const auto samples = driver_.Receive(delivery.bytes, delivery.at);
      for (const auto& sample : samples.wheel) Publish(wire::kWheel, wire::Encode(sample));
      for (const auto& sample : samples.imu) Publish(wire::kImu, wire::Encode(sample));
    }
    truth_.push_back(BodyPose());
    camera_.AdvanceTo(now_us_);
    for (const int fd : camera_node_.fds()) {
      pollfd ready{fd, POLLIN, 0};
      if (::poll(&ready, 1, 0) == 1) camera_node_.Read(fd);
    }
    if (now_us_ % 20'000 == 0) camera_node_.Tick();
    EXPECT_TRUE(bus_.Pump(0));
    if (now_us_ % 50'000 == 0) Control();
    if (now_us_ % 5'000 == 0) {
      const auto bytes = driver_.Tick(now());
      if (!bytes.empty()) base_.Write(bytes, now());
    }
  }

  bool finished() const { return follower_.finished(); }
  double seconds() const { return static_cast<double>(now_us_ - kStartUs) * 1e-6; }
  const tools::SlamSession& session() const { return session_; }
  const Health& camera_health() const { return camera_health_; }
  kobuki::Condition base_condition() const { return driver_.GetCondition(now()); }
  int64_t messages(const char* channel) const { return messages_.at(channel); }
  SE3 BodyPose() const {
    return PoseInPlane(start_.position.x(), start_.position.y(), start_.yaw) *
           PoseInPlane(base_.x_m(), base_.y_m(), base_.yaw_rad());
  }
  SE3 TrueBodyPose(Utime utime) const {
    // The first exposure began before the first step, when the robot stood.
    const int64_t step = (utime.us - kOffsetUs - kStartUs) / 1000 - 1;
    return truth_.at(static_cast<size_t>(std::max<int64_t>(step, 0)));
  }
  SE3 EstimatedBodyPose(const FramePose& frame) const {
    return truth_.front() * session_.frames().front().T_WB.inverse() * frame.T_WB;
  }

 private:
  static SE3 PoseInPlane(double x, double y, double yaw) {
    return SE3(ExpSO3({0, 0, yaw}), {x, y, 0});
  }
  static std::vector<Eigen::Vector2d> KeepFree(const std::vector<floorplan::Waypoint>& stops,
                                               const std::vector<floorplan::Leg>& legs) {
    std::vector<Eigen::Vector2d> out;
    out.reserve(stops.size());
    for (const auto& stop : stops) out.push_back(stop.position);
    for (const auto& leg : legs) out.insert(out.end(), leg.begin(), leg.end());
    return out;
  }

  Utime now() const { return {now_us_ + kOffsetUs}; }

  void Publish(const char* channel, const wire::Bytes& message) {
    EXPECT_TRUE(bus_.Publish(channel, message));
  }

  camera::EmulatedScene See(int64_t frame) {
    const SE3 T_GC =
        TrueBodyPose({camera_.MidExposureUs(frame) + kOffsetUs}) * config_.calibration.camera.T_BC;
    const sim::Exposure exposure{camera_.exposure_us() * 1e-3, 1};
    const auto key = static_cast<uint64_t>(2 * frame);
    camera::EmulatedScene out;
    renderer_.Render(T_GC, 1, &rendered_);
    left_eye_.Expose(rendered_, {}, exposure, {}, key, &out.left);
    renderer_.Render(T_GC * config_.calibration.camera.T_C0C1, 1, &rendered_);
    right_eye_.Expose(rendered_, {}, exposure, {}, key + 1, &out.right);
    out.depth.assign(out.left.size(), 0);
    return out;
  }

  void Control() {
    if (session_.frames().empty() || finished()) return;
    const SE3 T_GB = EstimatedBodyPose(session_.frames().back());
    const Eigen::Vector3d forward = T_GB.rotation() * Eigen::Vector3d::UnitX();
    const floorplan::Speed speed = follower_.Update(seconds(), T_GB.translation().head<2>(),
                                                    std::atan2(forward.y(), forward.x()));
    driver_.Command({now(), ++commands_, speed.v, speed.w}, now());
  }

  RobotConfig config_;
  floorplan::Waypoint start_;
  sim::WorkerPool pool_{1};
  sim::World world_;
  sim::Renderer renderer_;
  sim::CameraSensor left_eye_, right_eye_;
  sim::RenderedImage rendered_;
  sim::PathFollower follower_;
  int64_t now_us_ = kStartUs;
  process::MemoryBus bus_;
  camera::FakeSystem system_;
  camera::EmulatedCamera camera_;
  camera::CameraNode camera_node_;
  kobuki::Emulator base_;
  kobuki::Driver driver_;
  tools::SlamSession session_;
  std::vector<SE3> truth_;  // T_GB at each millisecond
  std::map<std::string, int64_t> messages_;
  Health camera_health_;
  int64_t commands_ = 0;
};

TEST(EmulatedDrive, DriversFeedThePosesThatDriveTheRobotRound) {
  const std::vector<floorplan::Waypoint> stops = {
      {{1.5, 1.3}, 0}, {{3.6, 1.3}, 1.57}, {{3.9, 3.3}, 3.14}, {{1.5, 1.3}, 0}};
  const auto legs = floorplan::PlanLegs(floorplan::RoomForTest(), stops, 0.25);
  ASSERT_TRUE(legs) << legs.error().message;
  EmulatedRobot robot(stops, *legs);
  while (!robot.finished() && robot.seconds() < 90) robot.Step();
  ASSERT_TRUE(robot.finished()) << "after " << robot.session().frames().size() << " images at "
                                << robot.BodyPose().translation().transpose();

  const auto& frames = robot.session().frames();
  double sum = 0;
  double worst = 0;
  int64_t lost = 0, weak = 0;
  for (const FramePose& frame : frames) {
    const bool degraded = frame.status == TrackingStatus::kDegraded;
    weak += degraded;
    lost += frame.status != TrackingStatus::kTracking && !degraded;
    const double error = (robot.EstimatedBodyPose(frame).translation() -
                          robot.TrueBodyPose(frame.utime).translation())
                             .norm();
    sum += error * error;
    worst = std::max(worst, error);
  }
  const double rmse = std::sqrt(sum / static_cast<double>(frames.size()));
  const double home = (robot.BodyPose().translation().head<2>() - stops.back().position).norm();
  std::printf(
      "%.1f s; CAMERA %lld, WHEEL %lld, IMU %lld; poses: %zu, without vision %lld, degraded %lld, "
      "RMSE %.4f m, worst %.4f m; the robot ends %.3f m from home\n",
      robot.seconds(), static_cast<long long>(robot.messages(wire::kCamera)),
      static_cast<long long>(robot.messages(wire::kWheel)),
      static_cast<long long>(robot.messages(wire::kImu)), frames.size(),
      static_cast<long long>(lost), static_cast<long long>(weak), rmse, worst, home);
  EXPECT_EQ(robot.camera_health().state, HealthState::kOk) << robot.camera_health().message;
  EXPECT_EQ(robot.base_condition().state, HealthState::kOk) << robot.base_condition().message;
  EXPECT_LT(lost, 5);
  EXPECT_LT(static_cast<double>(weak), 0.05 * static_cast<double>(frames.size()));
  EXPECT_LT(rmse, 0.05);
  EXPECT_LT(home, 0.15);
}

}  // namespace
}  // namespace gw

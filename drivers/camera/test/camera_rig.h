// The camera node on an emulated camera, a fake /dev and /sys and a bus in memory, in virtual time.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/process/bus.h"
#include "common/process/file_handle.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "drivers/camera/device/camera_node.h"
#include "drivers/common/bytes.h"
#include "test/emulators/camera/dot_projector.h"
#include "test/emulators/camera/emulated_camera.h"
#include "test/emulators/camera/fake_system.h"

namespace gw::camera {

inline RobotConfig ConfigForTest(CameraKind kind) {
  RobotConfig config;
  config.robot.name = "test";
  CameraCalibration& camera = config.calibration.camera;
  camera.kind = kind;
  camera.width = 640;
  camera.height = 480;
  camera.rate_hz = 30;
  camera.left = camera.right = {385, 385, 320, 240, {}};
  camera.T_C0C1 = SE3(Eigen::Quaterniond::Identity(), {0.05, 0, 0});
  config.calibration.imu.present = true;
  config.calibration.imu.rate_hz = 200;
  config.drivers.camera.transport_delay_ms = 5;  // the delay of the emulator
  return config;
}

// A scene: a wall 2 m away with squares of two greys; the first pixels hold the number of the
// frame.
class SceneForTest {
 public:
  SceneForTest() {
    const size_t pixels = size_t{640} * 480;
    for (size_t i = 0; i < pixels; ++i) {
      const bool light = (i % 640 / 20 + i / 640 / 20) % 2 == 0;
      unlit_.push_back(light ? 120 : 80);
    }
    std::vector<float> radiance(unlit_.begin(), unlit_.end());
    for (float& value : radiance) value /= 120;
    ProjectDots({}, 3, 640, 480, std::vector<float>(pixels, 0.5F), &radiance);
    for (const float value : radiance) {
      lit_.push_back(static_cast<uint8_t>(std::min(255.F, 120 * value)));
    }
  }

  EmulatedScene operator()(int64_t frame, bool emitter_on) const {
    EmulatedScene scene;
    scene.left = emitter_on || foreign_projector ? lit_ : unlit_;
    if (dark) scene.left.assign(scene.left.size(), 12);
    scene.right = scene.left;
    scene.depth.assign(scene.left.size(), 2000);
    scene.left[0] = static_cast<uint8_t>(frame);
    scene.right[0] = static_cast<uint8_t>(frame + 100);
    scene.depth[0] = static_cast<uint16_t>(frame);
    return scene;
  }

  bool foreign_projector = false;
  bool dark = false;

 private:
  std::vector<uint8_t> unlit_, lit_;
};

class CameraRig {
 public:
  using Frame = wire::DecodedCamera;

  explicit CameraRig(const RobotConfig& config, EmulatedCameraConfig emulated = {},
                     FakeSystem::UsbCamera usb = {.port = "2-1"})
      : system_(std::filesystem::temp_directory_path() /
                ("camera_rig_" + std::to_string(::getpid()))),
        usb_(std::move(usb)),
        camera_(
            [&] {
              emulated.dev = system_.roots().dev;
              return emulated;
            }(),
            [this](int64_t frame, bool on) { return scene(frame, on); }),
        now_us_(emulated.start_us),
        node_(config, &bus_,
              {.calls = &camera_,
               .roots = system_.roots(),
               .now = [this] { return Utime{now_us_ + kOffsetUs}; },
               .monotonic_offset = {kOffsetUs},
               .reset_usb = [this](int bus, int address) -> Result<Done> {
                 resets.emplace_back(bus, address);
                 if (on_reset) on_reset();
                 return Done{};
               }},
              process::LogLine(Milliseconds(0), [this](const std::string& l) { log += l; })) {
    system_.Plug(usb_);
    OpenMotionNodes();
    Listen();
  }

  void Run(double seconds) {
    for (const int64_t end = now_us_ + std::llround(1e6 * seconds); now_us_ < end;) {
      now_us_ += kStepUs;
      camera_.AdvanceTo(now_us_);
      if (motion_on) FeedMotion();
      for (const int fd : node_.fds()) {
        pollfd ready{fd, POLLIN, 0};
        if (::poll(&ready, 1, 0) == 1) node_.Read(fd);
      }
      if (now_us_ % 20'000 == 0) node_.Tick();
      (void)bus_.Pump(0);
    }
  }

  void Unplug() {
    camera_.Unplug();
    motion_nodes_.clear();
    system_.Unplug(usb_);
  }
  void Plug() {
    system_.Plug(usb_);
    OpenMotionNodes();
    camera_.Plug();
  }

  // The error of a frame's time against the truth; its number is in its first pixel, modulo 256.
  double TimeErrorMs(const Frame& frame) const {
    const int number = frame.frame.left.data[0];
    const Utime truth{camera_.MidExposureUs(number) + kOffsetUs};
    const double all = 256 * 1e6 / 30;
    const double error_us = static_cast<double>((frame.frame.utime - truth).us);
    return (error_us - std::round(error_us / all) * all) * 1e-3;
  }

  EmulatedCamera& camera() { return camera_; }
  CameraNode& node() { return node_; }
  FakeSystem& system() { return system_; }
  int64_t counter(const std::string& name) const {
    for (const auto& [key, value] : health.counters) {
      if (key == name) return value;
    }
    return -1;
  }

  SceneForTest scene;
  bool motion_on = true;
  int64_t motion_clock_error_us = 0;
  std::array<int32_t, 3> raw_gyro{1000, 2000, 3000}, raw_accel{10, -1000, 20};
  std::function<void()> on_reset;
  std::vector<std::pair<int, int>> resets;
  std::vector<Frame> frames;
  std::vector<ImuSample> imu;
  Health health;
  std::string log;

  static constexpr int64_t kOffsetUs = 1'700'000'000'000'000;

 private:
  static constexpr int64_t kStepUs = 1000;

  void Listen() {
    const auto ok = [](bool subscribed) { GW_CHECK(subscribed); };
    ok(bus_.Subscribe(
               wire::kCamera,
               [this](auto bytes, Utime) { frames.push_back(wire::Decode<Frame>(bytes).value()); })
           .ok());
    ok(bus_.Subscribe(
               wire::kImu,
               [this](auto bytes, Utime) { imu.push_back(wire::Decode<ImuSample>(bytes).value()); })
           .ok());
    ok(bus_.Subscribe(wire::kHealth,
                      [this](auto bytes, Utime) { health = wire::Decode<Health>(bytes).value(); })
           .ok());
  }

  // Opens the other ends of the nodes of accelerometer and gyro.
  void OpenMotionNodes() {
    motion_nodes_.clear();
    for (int i = 0; i < 2; ++i) {
      const std::string path =
          system_.roots().dev + "/iio:device" + std::to_string(usb_.first_iio + i);
      motion_nodes_.emplace_back(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
    }
  }

  // Feeds the accelerometer every 4 ms and the gyro every 5 ms; samples are 1 ms old when they can
  // be read.
  void FeedMotion() {
    if (motion_nodes_.empty()) return;
    if (now_us_ % 4000 == 0) WriteRow(0, raw_accel);
    if (now_us_ % 5000 == 0) WriteRow(1, raw_gyro);
  }
  void WriteRow(size_t node, const std::array<int32_t, 3>& raw) {
    std::vector<uint8_t> row;
    for (const int32_t value : raw) AppendU32(static_cast<uint32_t>(value), &row);
    AppendU32(0, &row);
    AppendU64(static_cast<uint64_t>(now_us_ - 1000 + motion_clock_error_us) * 1000, &row);
    (void)!::write(motion_nodes_[node].get(), row.data(), row.size());
  }

  FakeSystem system_;
  FakeSystem::UsbCamera usb_;
  EmulatedCamera camera_;
  process::MemoryBus bus_;
  int64_t now_us_;
  std::vector<process::FileHandle> motion_nodes_;
  CameraNode node_;
};

}  // namespace gw::camera

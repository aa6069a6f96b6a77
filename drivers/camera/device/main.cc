// gw-camera: the camera and its IMU on the bus.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "common/cli/command.h"
#include "common/config/loader.h"
#include "common/core/exit_code.h"
#include "common/process/bus.h"
#include "common/process/clock.h"
#include "common/process/loop.h"
#include "common/process/sd_notify.h"
#include "drivers/camera/device/camera_node.h"
#include "drivers/camera/device/usb_reset.h"
#include "drivers/camera/device/write_calibration.h"

namespace gw::camera {
namespace {

constexpr DurationUs kTick = Milliseconds(20);
// The option --check watches for this long, enough for the first images and for what they show.
constexpr DurationUs kCheckFor = Milliseconds(6000);
constexpr int64_t kCheckFrames = 90;

int Fail(const Error& error) {
  std::fprintf(stderr, "gw-camera: %s\n", error.message.c_str());
  return ExitCodeFor(error);
}

// Waits for the devices and the tick, and serves the node. Gives false when the signal to stop
// came.
Result<bool> Step(process::Loop* loop, CameraNode* node, std::vector<int>* watched) {
  const std::vector<int> wanted = node->fds();
  if (wanted != *watched) {
    for (const int fd : *watched) loop->Unwatch(fd);
    for (const int fd : wanted) loop->Watch(fd);
    *watched = wanted;
  }
  const auto ready = loop->Wait();
  if (!ready) return ready.error();
  for (const int fd : ready->fds) {
    // Reading one descriptor may close all.
    const std::vector<int> open = node->fds();
    if (std::find(open.begin(), open.end(), fd) != open.end()) node->Read(fd);
  }
  if (ready->tick) node->Tick();
  return !ready->stop;
}

// The option --check: says whether there is a camera, which one, and how it does.
int Check(process::Loop* loop, CameraNode* node, const process::Clock& clock) {
  const Utime end = clock.Now() + kCheckFor;
  std::vector<int> watched;
  node->Tick();
  // A camera that cannot be opened now will not come by waiting.
  while (node->streaming() && clock.Now() < end && node->frames() < kCheckFrames) {
    const auto going_on = Step(loop, node, &watched);
    if (!going_on) return Fail(going_on.error());
    if (!*going_on) break;
  }
  if (node->absent()) return Fail(*node->absent());
  const FoundCamera& found = node->found();
  std::printf("%s %s, USB %d Mbit/s\n", found.product.c_str(), found.serial.c_str(),
              found.speed_mbps);
  if (const auto& version = node->camera()->version()) {
    std::printf("firmware %s\n", version->firmware.text().c_str());
  }
  std::printf("%s\n%lld images\n", node->camera()->text().c_str(),
              static_cast<long long>(node->frames()));
  if (node->motion().wanted()) std::printf("IMU: %s\n", node->motion().open() ? "yes" : "no");
  for (const std::string& warning : node->Warnings()) std::printf("%s\n", warning.c_str());
  if (node->frames() > 0) return kExitOk;
  return Fail({ErrorCode::kIo,
               "the camera is there but delivers no images: use another port or "
               "cable"});
}

int WriteCalibration(const RobotConfig& config, const std::string& path) {
  const CameraConfig& camera = config.drivers.camera;
  const auto found = FindCamera(camera.source, camera.device);
  if (!found) return Fail(found.error());
  const auto opened = Camera::Open(&RealSystemCalls(), *found, camera, config.calibration.camera);
  if (!opened) return Fail(opened.error());
  const auto calibration = (*opened)->ReadCalibration();
  if (!calibration) return Fail(calibration.error());
  const auto written = WriteCalibratedConfig(WithCalibration(config, *calibration), path);
  if (!written) return Fail(written.error());
  std::printf("%s: fx %.3f fy %.3f cx %.3f cy %.3f px, baseline %.3f mm, of camera %s\n",
              path.c_str(), calibration->camera.fx, calibration->camera.fy, calibration->camera.cx,
              calibration->camera.cy, 1e3 * calibration->baseline_m, found->serial.c_str());
  return kExitOk;
}

int Run(const RobotConfig& config, const std::string& lcm_url, bool check) {
  // The loop is made first, so that no other thread takes the signals.
  auto loop = process::Loop::Create(kTick);
  if (!loop) return Fail(loop.error());
  const process::Clock clock;
  const CameraNode::System system{.calls = &RealSystemCalls(),
                                  .roots = {},
                                  .now = [&clock] { return clock.Now(); },
                                  .monotonic_offset = clock.monotonic_offset(),
                                  .reset_usb = ResetUsbDevice};
  if (check) {
    const auto quiet = [](const std::string&) {};
    CameraNode node(config, nullptr, system, process::LogLine(Milliseconds(1000), quiet));
    return Check(&*loop, &node, clock);
  }
  auto bus = process::LiveBus::Create(lcm_url);
  if (!bus) return Fail(bus.error());
  CameraNode node(config, bus->get(), system, process::LogLine());
  const process::SdNotify systemd;
  systemd.Ready();
  std::vector<int> watched;
  while (!node.gave_up()) {
    const auto going_on = Step(&*loop, &node, &watched);
    if (!going_on) return Fail(going_on.error());
    if (!*going_on) break;
    systemd.Watchdog();
  }
  systemd.Stopping();
  return node.gave_up() ? Fail({ErrorCode::kIo, *node.gave_up()}) : kExitOk;
}

int Main(int argc, char** argv) {
  std::string config_path;
  std::string lcm_url;
  std::string calibration_path;
  bool check = false;
  cli::Command app(
      "Driver of the camera: publishes CAMERA and IMU.\n"
      "Exit: 0 ok, 1 failed (the camera is there but cannot be made to deliver; with --check and\n"
      "--write-calibration also: no camera, no permission), 2 usage, 78 bad configuration.");
  app.AddOption("--config", config_path, "YAML of the robot")->Required();
  app.AddOption("--lcm-url", lcm_url, "bus, instead of process.lcm_url of the configuration");
  auto* check_flag =
      app.AddFlag("--check", check, "check configuration and camera, say what is there, and exit");
  app.AddOption("--write-calibration", calibration_path,
                "read the calibration stored in the camera, write it and the rest of --config to "
                "this file, and exit")
      ->Excludes(check_flag);
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  const auto config = LoadRobotConfig(config_path);
  if (!config) return Fail(config.error());
  if (!calibration_path.empty()) return WriteCalibration(*config, calibration_path);
  return Run(*config, lcm_url.empty() ? config->process.lcm_url : lcm_url, check);
}

}  // namespace
}  // namespace gw::camera

int main(int argc, char** argv) {
  return gw::camera::Main(argc, argv);
}

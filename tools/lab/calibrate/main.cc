// gw-calibrate: a robot's calibration from recordings and images.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <string>

#include "common/core/exit_code.h"
#include "common/core/version.h"
#include "tools/lab/calibrate/commands.h"

namespace gw::calibrate {
namespace {

struct Command {
  DriveOptions drive;
  ImuOptions imu;
  CameraOptions camera;
  std::function<Result<Done>()> run;
};

void AddDrive(CLI::App& app, Command& c) {
  CLI::App* const drive = app.add_subcommand(
      "drive",
      "where the camera is on the base, scales of wheels and gyro, delays; of a drive with "
      "turns and straight ways past textured things");
  drive->add_option("LOG", c.drive.log, "LCM log")->required();
  drive->add_option("--config", c.drive.config, "robot configuration (YAML) to begin with")
      ->required();
  drive->add_option("--config-out", c.drive.config_out, "the same with what was found")->required();
  drive->callback([&c] { c.run = [&c] { return RunDrive(c.drive); }; });
}

void AddImu(CLI::App& app, Command& c) {
  CLI::App* const imu = app.add_subcommand(
      "imu",
      "noise densities and random walks of gyro and accelerometer (Allan variance), units and "
      "axes; of a robot that stands for an hour");
  imu->add_option("LOG", c.imu.log, "LCM log")->required();
  imu->add_option("--config", c.imu.config, "robot configuration (YAML) to begin with")->required();
  imu->add_option("--config-out", c.imu.config_out, "the same with what was found")->required();
  imu->callback([&c] { c.run = [&c] { return RunImu(c.imu); }; });
}

void AddCamera(CLI::App& app, Command& c) {
  CLI::App* const camera = app.add_subcommand(
      "camera",
      "intrinsics, and of two eyes the pose between them, of images of a board held near and far, "
      "tilted to all sides, into every corner of the image");
  camera->add_option("IMAGES", c.camera.images, "folder of images (of the left eye)")->required();
  camera->add_option("--right", c.camera.right_images,
                     "folder of the right eye's images, pairs have the same name");
  camera
      ->add_option("--board", c.camera.board,
                   "apriltag:COLUMNSxROWS:SIDE_M:GAP (family 36h11; Kalibr's grid: "
                   "apriltag:6x6:0.088:0.3) or checkerboard:COLUMNSxROWS:SIDE_M (inner corners)")
      ->required();
  camera->add_option("--model", c.camera.model, "of the lens: radtan or equidistant (fisheye)")
      ->check(CLI::IsMember({"radtan", "equidistant"}))
      ->default_str("radtan");
  CLI::Option* const config =
      camera->add_option("--config", c.camera.config, "robot configuration (YAML) to begin with");
  CLI::Option* const config_out =
      camera->add_option("--config-out", c.camera.config_out, "the same with what was found");
  config->needs(config_out);
  config_out->needs(config);
  camera->add_option("--asl-out", c.camera.asl_out,
                     "folder to write cam0/sensor.yaml (and cam1/sensor.yaml) to, as "
                     "gw-import euroc reads them");
  camera->callback([&c] { c.run = [&c] { return RunCamera(c.camera); }; });
}

int Main(int argc, char** argv) {
  CLI::App app(
      "Calibrates a robot from recordings and images.\nExit: 0 ok, 1 failed, 2 usage, 78 bad "
      "configuration.");
  app.set_version_flag("--version", Version());
  app.require_subcommand(1);
  Command command;
  command.camera.model = "radtan";
  AddDrive(app, command);
  AddImu(app, command);
  AddCamera(app, command);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kExitOk : kExitUsage;
  }
  const Result<Done> done = command.run();
  if (done) return kExitOk;
  std::fprintf(stderr, "gw-calibrate: %s\n", done.error().message.c_str());
  return ExitCodeFor(done.error());
}

}  // namespace
}  // namespace gw::calibrate

int main(int argc, char** argv) {
  return gw::calibrate::Main(argc, argv);
}

// gw-calibrate: a robot's calibration from recordings and images.
#include <cstdio>
#include <functional>
#include <string>

#include "common/cli/command.h"
#include "common/core/exit_code.h"
#include "tools/lab/calibrate/commands.h"

namespace gw::calibrate {
namespace {

struct Command {
  DriveOptions drive;
  ImuOptions imu;
  CameraOptions camera;
  std::function<Result<Done>()> run;
};

void AddDrive(cli::Command& app, Command& c) {
  cli::Command* const drive = app.AddCommand(
      "drive",
      "where the camera is on the base, scales of wheels and gyro, delays; of a drive with "
      "turns and straight ways past textured things");
  drive->AddOption("LOG", c.drive.log, "LCM log")->Required();
  drive->AddOption("--config", c.drive.config, "robot configuration (YAML) to begin with")
      ->Required();
  drive->AddOption("--config-out", c.drive.config_out, "the same with what was found")->Required();
  drive->WhenGiven([&c] { c.run = [&c] { return RunDrive(c.drive); }; });
}

void AddImu(cli::Command& app, Command& c) {
  cli::Command* const imu = app.AddCommand(
      "imu",
      "noise densities and random walks of gyro and accelerometer (Allan variance), units and "
      "axes; of a robot that stands for an hour");
  imu->AddOption("LOG", c.imu.log, "LCM log")->Required();
  imu->AddOption("--config", c.imu.config, "robot configuration (YAML) to begin with")->Required();
  imu->AddOption("--config-out", c.imu.config_out, "the same with what was found")->Required();
  imu->WhenGiven([&c] { c.run = [&c] { return RunImu(c.imu); }; });
}

void AddCamera(cli::Command& app, Command& c) {
  cli::Command* const camera = app.AddCommand(
      "camera",
      "intrinsics, and of two eyes the pose between them, of images of a board held near and far, "
      "tilted to all sides, into every corner of the image");
  camera->AddOption("IMAGES", c.camera.images, "folder of images (of the left eye)")->Required();
  camera->AddOption("--right", c.camera.right_images,
                    "folder of the right eye's images, pairs have the same name");
  camera
      ->AddOption("--board", c.camera.board,
                  "apriltag:COLUMNSxROWS:SIDE_M:GAP (family 36h11; Kalibr's grid: "
                  "apriltag:6x6:0.088:0.3) or checkerboard:COLUMNSxROWS:SIDE_M (inner corners)")
      ->Required();
  camera->AddOption("--model", c.camera.model, "of the lens: radtan or equidistant (fisheye)")
      ->OneOf({"radtan", "equidistant"})
      ->ShowDefault();
  cli::Option* const config =
      camera->AddOption("--config", c.camera.config, "robot configuration (YAML) to begin with");
  cli::Option* const config_out =
      camera->AddOption("--config-out", c.camera.config_out, "the same with what was found");
  config->Needs(config_out);
  config_out->Needs(config);
  camera->AddOption("--asl-out", c.camera.asl_out,
                    "folder to write cam0/sensor.yaml (and cam1/sensor.yaml) to, as "
                    "gw-import euroc reads them");
  camera->WhenGiven([&c] { c.run = [&c] { return RunCamera(c.camera); }; });
}

int Main(int argc, char** argv) {
  cli::Command app(
      "Calibrates a robot from recordings and images.\nExit: 0 ok, 1 failed, 2 usage, 78 bad "
      "configuration.");
  app.RequireCommands(1, 1);
  Command command;
  command.camera.model = "radtan";
  AddDrive(app, command);
  AddImu(app, command);
  AddCamera(app, command);
  if (const auto exit = app.Parse(argc, argv)) return *exit;
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

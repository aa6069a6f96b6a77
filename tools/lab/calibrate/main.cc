// gw-calibrate drive: the camera's place on the base, scales of wheels and gyro, delays, of a
// drive.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <string>

#include "common/config/loader.h"
#include "common/config/writer.h"
#include "common/core/exit_code.h"
#include "common/core/version.h"
#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/data/files/format.h"
#include "tools/data/files/text_file.h"
#include "tools/lab/calibrate/drive_calibration.h"
#include "tools/lab/check/vision_motion.h"

namespace gw::calibrate {
namespace {

using tools::Format;

struct RawMotion {
  std::vector<WheelSample> wheels;
  std::vector<ImuSample> imu;
};

Result<RawMotion> ReadMotion(const std::string& log) {
  auto reader = process::EventLogReader::Open(log);
  if (!reader) return reader.error();
  RawMotion motion;
  while (const auto event = reader->Next()) {
    if (event->channel == wire::kWheel) {
      if (auto sample = wire::Decode<WheelSample>(event->data)) motion.wheels.push_back(*sample);
    } else if (event->channel == wire::kImu) {
      if (auto sample = wire::Decode<ImuSample>(event->data)) motion.imu.push_back(*sample);
    }
  }
  if (reader->error()) return *reader->error();
  return motion;
}

std::string ReportText(const DriveCalibration& found) {
  std::string text = Format("%d steps of half a second, %.1f m, %.0f deg of turns\n", found.steps,
                            found.way_m, found.turn_rad * 180 / M_PI);
  int undetermined = 0;
  for (const Quantity& q : found.quantities) {
    if (q.determined()) {
      text += Format("  %-17s %10.4f +- %.4f %s\n", q.name, q.value, q.sigma, q.unit);
    } else {
      ++undetermined;
      text += Format("  %-17s not determined by this drive: %s\n", q.name, q.remedy);
    }
  }
  text +=
      "camera: the correction to the T_BC that was given, about and along the body's axes; its "
      "height is not told by a floor. Scales: true over measured motion\n";
  text += undetermined == 0 ? "all determined\n"
                            : Format("%d not determined: those stay as they were\n", undetermined);
  return text;
}

Result<Done> Run(const std::string& log, const std::string& config_file, const std::string& out) {
  Result<RobotConfig> config = LoadRobotConfig(config_file);
  if (!config) return config.error();
  const Result<RawMotion> motion = ReadMotion(log);
  if (!motion) return motion.error();
  const Result<check::VisionRun> vision = check::RunVision(log, *config);
  if (!vision) return vision.error();
  std::vector<CameraPose> poses;
  for (const check::VisionPose& pose : vision->poses) {
    poses.push_back({pose.utime, pose.T_WB * config->calibration.camera.T_BC, pose.seen});
  }
  const Result<DriveCalibration> found =
      CalibrateDrive(poses, motion->wheels, motion->imu, config->calibration);
  if (!found) return Error{found.error().code, log + ": " + found.error().message};
  const Quantity& way = found->quantities[kWheelWay];
  const Quantity& turn = found->quantities[kWheelTurn];
  config->calibration = Corrected(config->calibration, *found);
  const Result<Done> written =
      tools::WriteTextFile(out, WriteRobotConfig(*config, ConfigText::kShort));
  if (!written) return written.error();
  std::fputs(ReportText(*found).c_str(), stdout);
  std::printf(
      "%s: T_BC and time offsets; ticks_per_metre and track_width_m for a driver that counts "
      "ticks (times %.4f and %.4f)\n",
      out.c_str(), 1 / way.value, way.value / turn.value);
  return Done{};
}

int Main(int argc, char** argv) {
  std::string log, config, out;
  CLI::App app(
      "Calibrates a robot from recordings.\nExit: 0 ok, 1 failed, 2 usage, 78 bad "
      "configuration.");
  app.set_version_flag("--version", Version());
  app.require_subcommand(1);
  CLI::App* const drive = app.add_subcommand(
      "drive",
      "where the camera is on the base, scales of wheels and gyro, delays; of a drive with "
      "turns and straight ways past textured things");
  drive->add_option("LOG", log, "LCM log")->required();
  drive->add_option("--config", config, "robot configuration (YAML) to begin with")->required();
  drive->add_option("--config-out", out, "the same with what was found")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kExitOk : kExitUsage;
  }
  const Result<Done> done = Run(log, config, out);
  if (done) return kExitOk;
  std::fprintf(stderr, "gw-calibrate: %s\n", done.error().message.c_str());
  return ExitCodeFor(done.error());
}

}  // namespace
}  // namespace gw::calibrate

int main(int argc, char** argv) {
  return gw::calibrate::Main(argc, argv);
}

#include <cmath>
#include <cstdio>
#include <string>

#include "common/config/loader.h"
#include "tools/data/files/format.h"
#include "tools/lab/calibrate/commands.h"
#include "tools/lab/calibrate/commented_config.h"
#include "tools/lab/calibrate/drive_calibration.h"
#include "tools/lab/calibrate/raw_motion.h"
#include "tools/lab/check/vision_motion.h"

namespace gw::calibrate {
namespace {

using tools::Format;

std::string ReportText(const DriveCalibration& found) {
  std::string text = Format("%d steps of half a second, %.1f m, %.0f deg of turns\n", found.steps,
                            found.way_m, found.turn_rad * 180 / M_PI);
  int coarse = 0, undetermined = 0;
  for (const Quantity& q : found.quantities) {
    if (!q.determined()) {
      ++undetermined;
      text += Format("  %-17s not determined by this drive: %s\n", q.name, q.remedy);
      continue;
    }
    text += Format("  %-17s %10.4f +- %.4f%s%s", q.name, q.value, q.sigma,
                   q.unit.empty() ? "" : " ", q.unit);
    if (!q.exact()) {
      ++coarse;
      text += Format(", not yet to %.1g: %s", q.wanted, q.remedy);
    }
    text += "\n";
  }
  text +=
      "camera: the correction to the T_BC that was given, about and along the body's axes; its "
      "height is not told by a floor. Scales: true over measured motion\n";
  text += coarse + undetermined == 0 ? "all determined\n"
                                     : Format(
                                           "%d known, but not yet as well as is wanted; %d not "
                                           "determined, which stay as they were\n",
                                           coarse, undetermined);
  if (const std::string missing = MissingMotion(found); !missing.empty()) text += missing + "\n";
  return text;
}

// What the configuration has of the wheels' scales.
std::string WheelText(const Quantity& way, const Quantity& turn) {
  if (!way.determined()) return "; ticks_per_metre and track_width_m stay as they were";
  if (!turn.determined()) {
    return Format(
        "; ticks_per_metre for a driver that counts ticks (times %.4f); track_width_m "
        "stays as it was",
        1 / way.value);
  }
  return Format(
      "; ticks_per_metre and track_width_m for a driver that counts ticks (times %.4f and %.4f)",
      1 / way.value, way.value / turn.value);
}

}  // namespace

Result<Done> RunDrive(const DriveOptions& options) {
  Result<RobotConfig> config = LoadRobotConfig(options.config);
  if (!config) return config.error();
  const Result<RawMotion> motion = ReadMotion(options.log);
  if (!motion) return motion.error();
  if (motion->images == 0) {
    return Error{ErrorCode::kBadData,
                 options.log +
                     " has no images: the camera tells what wheels and gyro are off by, and where "
                     "it is itself; record the drive with the camera on"};
  }
  const Result<check::VisionRun> vision = check::RunVision(options.log, *config);
  if (!vision) return vision.error();
  std::vector<CameraPose> poses;
  for (const check::VisionPose& pose : vision->poses) {
    poses.push_back({pose.utime, pose.T_WB * config->calibration.camera.T_BC, pose.seen});
  }
  const Result<DriveCalibration> found =
      CalibrateDrive(poses, motion->wheels, motion->imu, config->calibration);
  if (!found) return Error{found.error().code, options.log + ": " + found.error().message};
  const Quantity& way = found->quantities[kWheelWay];
  const Quantity& turn = found->quantities[kWheelTurn];
  config->calibration = Corrected(config->calibration, *found);
  const std::string report = ReportText(*found);
  const Result<Done> written =
      WriteCommented(options.config_out, "gw-calibrate drive " + options.log, report, *config);
  if (!written) return written.error();
  std::fputs(report.c_str(), stdout);
  std::printf("%s: T_BC and time offsets%s\n", options.config_out.c_str(),
              WheelText(way, turn).c_str());
  return Done{};
}

}  // namespace gw::calibrate

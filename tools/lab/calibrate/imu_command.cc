#include <cstdio>
#include <string>

#include "common/config/loader.h"
#include "tools/data/files/format.h"
#include "tools/lab/calibrate/commands.h"
#include "tools/lab/calibrate/commented_config.h"
#include "tools/lab/calibrate/imu_noise.h"
#include "tools/lab/calibrate/raw_motion.h"

namespace gw::calibrate {
namespace {

using tools::Format;

std::string TermText(const char* name, const NoiseTerm& term, const char* unit) {
  if (!term.determined()) {
    return Format("    %-17s not told by this standstill: below %.2e %s\n", name,
                  term.value + 2 * term.sigma, unit);
  }
  return Format("    %-17s %.3e +- %.1e %s\n", name, term.value, term.sigma, unit);
}

std::string TriadText(const char* name, const TriadNoise& sensor, const char* unit) {
  std::string text = Format("  %s, mean %.5f %.5f %.5f %s\n", name, sensor.mean.x(),
                            sensor.mean.y(), sensor.mean.z(), unit);
  const std::string density_unit = std::string(unit) + "/sqrt(Hz)";
  const std::string walk_unit = std::string(unit) + "/s/sqrt(Hz)";
  for (size_t axis = 0; axis < 3; ++axis) {
    const NoiseModel& noise = sensor.axes[axis];
    text += Format("   %c\n", "xyz"[axis]);
    text += TermText("noise density", noise.density, density_unit.c_str());
    text += TermText("bias instability", noise.instability, unit);
    text += TermText("random walk", noise.walk, walk_unit.c_str());
  }
  return text;
}

std::string ReportText(const ImuNoise& found) {
  std::string text = Format("parked for %.0f s, %.1f Hz, %d lost samples\n", found.parked_s,
                            found.rate_hz, found.filled);
  text += TriadText("gyro", found.gyro, "rad/s");
  if (found.has_accel) text += TriadText("accelerometer", found.accel, "m/s^2");
  return text;
}

std::string KeysText(const ImuCalibration& given, const ImuCalibration& out) {
  std::string text = "the largest axis of each, in calibration.imu:\n";
  for (const auto& [name, before, after] :
       {std::tuple{"gyro_noise", given.gyro_noise, out.gyro_noise},
        {"gyro_walk", given.gyro_walk, out.gyro_walk},
        {"accel_noise", given.accel_noise, out.accel_noise},
        {"accel_walk", given.accel_walk, out.accel_walk}}) {
    text += before == after ? Format("  %-11s %.3e as it was\n", name, before)
                            : Format("  %-11s %.3e (was %.3e)\n", name, after, before);
  }
  return text;
}

}  // namespace

Result<Done> RunImu(const ImuOptions& options) {
  Result<RobotConfig> config = LoadRobotConfig(options.config);
  if (!config) return config.error();
  const Result<RawMotion> motion = ReadMotion(options.log);
  if (!motion) return motion.error();
  const Result<ImuNoise> found = MeasureImuNoise(motion->imu, motion->wheels);
  if (!found) return Error{found.error().code, options.log + ": " + found.error().message};
  Calibration& calibration = config->calibration;
  const std::vector<std::string> faults = JudgeStandstill(*found, calibration);
  const ImuCalibration given = calibration.imu;
  calibration.imu = WithNoise(given, *found);
  const std::string report = ReportText(*found) + KeysText(given, calibration.imu);
  std::fputs(report.c_str(), stdout);
  if (!faults.empty()) {
    std::string text = options.log + ": nothing was written, mend first:";
    for (const std::string& fault : faults) text += "\n  " + fault;
    return Error{ErrorCode::kBadData, text};
  }
  Result<Done> written =
      WriteCommented(options.config_out, "gw-calibrate imu " + options.log, report, *config);
  if (!written) return written;
  std::printf("units, gravity and axes are right; written to %s\n", options.config_out.c_str());
  if (found->parked_s < 1800) {
    std::printf("an hour of standing tells the random walks better than these %.0f minutes\n",
                found->parked_s / 60);
  }
  return Done{};
}

}  // namespace gw::calibrate

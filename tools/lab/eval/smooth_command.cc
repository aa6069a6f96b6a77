#include "tools/lab/eval/smooth_command.h"

#include <cstdio>
#include <numbers>

#include "common/config/loader.h"
#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/data/files/format.h"
#include "tools/data/files/text_file.h"
#include "tools/lab/eval/smooth.h"

namespace gw::eval {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

// The rates of the log's IMU, in the body frame.
Result<std::vector<BodyRate>> ReadGyro(const std::string& path, const std::string& config_path) {
  const auto config = LoadRobotConfig(config_path);
  if (!config) return config.error();
  const Eigen::Quaterniond R_BI = config->calibration.imu.T_BI.rotation();
  auto log = process::EventLogReader::Open(path);
  if (!log) return log.error();
  std::vector<BodyRate> out;
  while (const auto event = log->Next()) {
    if (event->channel != wire::kImu) continue;
    const auto imu = wire::Decode<ImuSample>(event->data);
    if (!imu || (!out.empty() && imu->utime <= out.back().utime)) continue;
    out.push_back({imu->utime, R_BI * imu->w_I_rad_s});
  }
  if (log->error()) return *log->error();
  if (out.empty()) return Error{ErrorCode::kBadData, path + ": holds no IMU"};
  return out;
}

void Print(const Smoothed& smoothed, size_t samples) {
  std::printf("noise of a sample, per axis: %.5f m, %.4f deg (third differences)\n\n",
              smoothed.noise.position_m, kDegrees * smoothed.noise.rotation_rad);
  std::printf("knots every  left out: RMS m  median m  RMS deg  median deg  outliers of %zu\n",
              samples);
  for (size_t i = 0; i < smoothed.tried.size(); ++i) {
    const SpacingFit& fit = smoothed.tried[i];
    std::printf("%9.3f s %16.5f %9.5f %8.4f %11.4f %9lld%s\n", fit.spacing.seconds(),
                fit.left_out_m.rmse, fit.left_out_m.median, fit.left_out_deg.rmse,
                fit.left_out_deg.median, static_cast<long long>(fit.outliers),
                i == smoothed.chosen ? "  <- used" : "");
  }
  if (smoothed.has_gyro) {
    const Eigen::Vector3d b = kDegrees * smoothed.gyro_bias;
    std::printf("\ngyro bias in the body frame: %.4f %.4f %.4f deg/s\n", b.x(), b.y(), b.z());
  }
}

}  // namespace

cli::Command* AddSmoothCommand(cli::Command* app, SmoothArguments* args) {
  cli::Command* const sub = app->AddCommand(
      "smooth",
      "smooths a noisy trajectory, such as ground truth of a LiDAR at 10 Hz, with a B-spline on\n"
      "SE(3); prints how well each sample is foretold by the others (leave one out)");
  sub->AddOption("input", args->in, "TUM file, or LCM log (.lcm) with ground truth")->Required();
  sub->AddOption("--out", args->out, "smooth trajectory to write: TUM file")->Required();
  sub->AddOption("--rate", args->rate_hz, "Hz; of the poses that are written")
      ->ShowDefault()
      ->InRange(0.1, 10000.0);
  sub->AddOption("--knots", args->spacing_s,
                 "s between knots (the one that foretells left out samples best)")
      ->InRange(1e-3, 1e3);
  cli::Option* const gyro =
      sub->AddOption("--gyro", args->gyro, "LCM log whose gyro is used as well");
  cli::Option* const config =
      sub->AddOption("--config", args->config, "robot configuration of that log");
  gyro->Needs(config);
  config->Needs(gyro);
  return sub;
}

Result<Done> RunSmooth(const SmoothArguments& args) {
  const auto samples = ReadReference(args.in);
  if (!samples) return samples.error();
  SmoothOptions options;
  if (args.spacing_s > 0) options.spacing = DurationFromSeconds(args.spacing_s);
  if (!args.gyro.empty()) {
    auto gyro = ReadGyro(args.gyro, args.config);
    if (!gyro) return gyro.error();
    options.gyro = *std::move(gyro);
  }
  const auto smoothed = Smooth(*samples, options);
  if (!smoothed) return Error{smoothed.error().code, args.in + ": " + smoothed.error().message};
  Print(*smoothed, samples->size());
  std::string text;
  for (const TimedPose& pose : Sample(*smoothed, *samples, args.rate_hz)) {
    text += tools::TumLine(pose.utime, pose.T);
  }
  return tools::WriteTextFile(args.out, text);
}

}  // namespace gw::eval

// gw-import: recordings of public data sets as LCM logs with a robot configuration.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "common/cli/command.h"
#include "common/config/writer.h"
#include "common/core/exit_code.h"
#include "common/core/format.h"
#include "common/core/version.h"
#include "tools/data/files/json.h"
#include "tools/data/files/text_file.h"
#include "tools/data/import/camera_check.h"
#include "tools/data/import/cid_sims.h"
#include "tools/data/import/euroc.h"
#include "tools/data/import/imu_check.h"
#include "tools/data/import/kitti.h"
#include "tools/data/import/odometry.h"
#include "tools/data/import/openloris.h"
#include "tools/data/import/rosbag.h"
#include "tools/data/import/run_check.h"
#include "tools/data/import/synthetic_dr.h"
#include "tools/data/import/tum.h"
#include "tools/data/import/write_log.h"

namespace gw::importer {
namespace {

struct Arguments {
  std::string source, log, config, ground_truth_out, synthetic_dr;
  TrajectoryFrame frame = TrajectoryFrame::kBody;
  bool skip_missing = false;
  bool json = false;
  bool no_check = false;
  ImuCheckOptions imu;
};

void AddCommonOptions(cli::Command& app, Arguments& a, bool always_writes) {
  app.AddOption("SRC", a.source,
                "folder of the recording (rosbag: the file, or the folder of rosbag2)")
      ->Required();
  app.AddOption("--out", a.log, "LCM log to write")->Required(always_writes);
  app.AddOption("--config-out", a.config, "robot configuration (YAML) to write")
      ->Required(always_writes);
  app.AddFlag("--skip-missing", a.skip_missing,
              "leave out and count frames whose image files are not there or cannot be read");
  app.AddOption(
      "--dr-from-groundtruth", a.synthetic_dr,
      "add dead reckoning made from the ground truth: "
      "sigma_t=0.004,sigma_r=0.1deg,bias_t=0,bias_r=0deg,walk_t=0,walk_r=0deg,rate=100,"
      "seed=1 (sigma: m and deg or rad per 1/30 s; bias: per s; walk: per s and sqrt(s))");
  app.AddOption("--ground-truth-out", a.ground_truth_out, "ground truth as a TUM trajectory");
  app.AddChoice<TrajectoryFrame>(
      "--frame", a.frame, {{"body", TrajectoryFrame::kBody}, {"camera", TrajectoryFrame::kCamera}},
      "frame of --ground-truth-out: body or camera");
  app.AddChoice<GyroUnit>(
      "--gyro-unit", a.imu.gyro_unit,
      {{"auto", GyroUnit::kAuto}, {"rad/s", GyroUnit::kRadPerS}, {"deg/s", GyroUnit::kDegPerS}},
      "unit of the gyro: auto (decided by the data), rad/s or deg/s");
  app.AddChoice<AccelUnit>(
      "--accel-unit", a.imu.accel_unit,
      {{"auto", AccelUnit::kAuto}, {"m/s2", AccelUnit::kMetrePerS2}, {"g", AccelUnit::kG}},
      "unit of the accelerometer: auto (decided by the data), m/s2 or g");
  app.AddOption("--imu-time-offset", a.imu.time_offset_s,
                "s by which the IMU's clock is ahead of the other sensors'; taken off");
  app.AddFlag("--no-check", a.no_check, "do not run gw-check on what was imported");
  app.AddFlag("--json", a.json, "print the summary as JSON");
}

// Says how far it is, every two seconds.
class ProgressLine {
 public:
  void operator()(size_t done, size_t total) {
    const auto now = Clock::now();
    if (now - last_ < std::chrono::seconds(2)) return;
    last_ = now;
    std::fprintf(stderr, "gw-import: %zu of %zu images\n", done, total);
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

// findings: of gw-check; empty where it did not run.
std::string Summary(const Recording& recording, const LogSummary& log,
                    const std::optional<tools::Json>& findings, const Arguments& a) {
  const double duration_s = (log.end - log.begin).seconds();
  if (a.json) {
    return tools::JsonLine({{"program", "gw-import"},
                            {"version", Version()},
                            {"format", recording.format},
                            {"log", a.log},
                            {"config", a.config},
                            {"bytes", log.bytes},
                            {"duration_s", duration_s},
                            {"skipped_frames", recording.skipped_frames},
                            {"channels", log.messages},
                            {"warnings", recording.warnings},
                            {"findings", tools::ValueOrNull(findings)}});
  }
  std::string out = fmt::format("{}: {:.3f} s, {:.1f} MB, {} frames skipped\n", a.log, duration_s,
                                static_cast<double>(log.bytes) * 1e-6, recording.skipped_frames);
  for (const auto& [key, text] : recording.notes) {
    if (key == "topic") out += "  " + text + "\n";
  }
  for (const auto& [channel, count] : log.messages) {
    out += fmt::format("  {:<14} {}\n", channel, count);
  }
  if (findings) out += CheckText(*findings, a.log, a.config);
  return out;
}

// Findings about the log that was written; a check that cannot run costs a line, not the import.
std::optional<tools::Json> CheckFindings(const Arguments& a) {
  if (a.no_check) return std::nullopt;
  Result<tools::Json> findings = RunCheck(a.log, a.config);
  if (findings) return *std::move(findings);
  std::fprintf(stderr, "gw-import: warning: %s\n", findings.error().message.c_str());
  return std::nullopt;
}

// What the log says about its own making.
void AddProvenance(Recording& recording, const Arguments& a, const std::string& options) {
  std::vector<std::pair<std::string, std::string>> notes = {
      {"source", recording.format + " folder " + recording.name},
      {"importer", std::string("gw-import ") + Version() + " " + recording.format + options}};
  if (a.skip_missing) {
    notes.emplace_back(
        "skipped", std::to_string(recording.skipped_frames) + " frames whose files are not there");
  }
  recording.notes.insert(recording.notes.begin(), notes.begin(), notes.end());
}

Result<Done> Import(Recording recording, const Arguments& a,
                    const std::optional<SyntheticDrOptions>& dr, const std::string& options) {
  CheckImu(a.imu, recording);
  WarnOfPrincipalPoint(recording);
  DescribeSensors(recording);
  AddProvenance(recording, a, options);
  if (dr) {
    Result<std::vector<DrState>> states =
        MakeSyntheticDr(recording.ground_truth, *dr, recording.warnings);
    if (!states) return states.error();
    recording.dr = *std::move(states);
    recording.notes.emplace_back(
        "dr.synthetic", "DR is made from the ground truth, not measured: " + Describe(*dr));
  } else if (recording.imu.empty() && recording.wheel.empty()) {
    recording.warnings.emplace_back(
        "neither IMU nor wheels: no dead reckoning from this log (--dr-from-groundtruth makes "
        "one)");
  }
  for (const std::string& warning : recording.warnings) {
    std::fprintf(stderr, "gw-import: warning: %s\n", warning.c_str());
  }
  const Result<RobotConfig> config = MakeRobotConfig(recording);
  if (!config) return config.error();
  const Result<LogSummary> log = WriteLog(recording, a.log, a.skip_missing, ProgressLine());
  if (!log) return log.error();
  recording.skipped_frames += log->broken_frames;
  const Result<Done> config_written =
      tools::WriteTextFile(a.config, WriteRobotConfig(*config, ConfigText::kShort));
  if (!config_written) return config_written.error();
  if (!a.ground_truth_out.empty()) {
    const Result<Done> written =
        tools::WriteTextFile(a.ground_truth_out, GroundTruthText(recording, a.frame));
    if (!written) return written.error();
  }
  std::fputs(Summary(recording, *log, CheckFindings(a), a).c_str(), stdout);
  return Done{};
}

// What the command line asks for.
struct Command {
  Arguments common;
  std::function<Result<Recording>()> read;
  std::string options;  // of the format, for the log's note
  TumOptions tum;
  std::string intrinsics;
  double depth_unit_m = 0;
  CidSimsOptions cid;
  OpenLorisOptions loris;
  OdometryOptions odometry;
  RosbagOptions bag;
  bool list_bag = false;
};

cli::Command* AddFormat(cli::Command& app, const std::string& name, const std::string& text,
                        Command& command, bool always_writes = true) {
  cli::Command* const format = app.AddCommand(name, text);
  AddCommonOptions(*format, command.common, always_writes);
  return format;
}

Result<Recording> ReadTumCommand(Command& c) {
  if (!c.intrinsics.empty()) {
    const Result<PinholeIntrinsics> parsed = ParseIntrinsics(c.intrinsics);
    if (!parsed) return parsed.error();
    c.tum.intrinsics = *parsed;
    c.options += " --intrinsics " + c.intrinsics;
  } else if (!c.tum.camera.empty()) {
    c.options += " --camera " + c.tum.camera;
  }
  if (c.depth_unit_m > 0) {
    c.tum.depth_unit_m = c.depth_unit_m;
    c.options += " --depth-unit " + FormatDouble(c.depth_unit_m);
  }
  c.tum.skip_missing = c.common.skip_missing;
  return ReadTum(c.common.source, c.tum);
}

void AddTum(cli::Command& app, Command& c) {
  cli::Command* const tum =
      AddFormat(app, "tum", "TUM RGB-D, or a camera of your own in its layout", c);
  tum->AddOption("--camera", c.tum.camera,
                 "preset of the camera: fr1, fr2 or fr3 (default: as the folder's name says)");
  tum->AddOption("--intrinsics", c.intrinsics,
                 "instead of a preset: fx,fy,cx,cy or fx,fy,cx,cy,k1,k2,p1,p2,k3");
  tum->AddOption("--depth-unit", c.depth_unit_m,
                 "metres per unit of the depth images: 0.001 for millimetres (default: TUM's "
                 "1/5000)")
      ->InRange(1e-6, 0.1);
  tum->WhenGiven([&c] { c.read = [&c] { return ReadTumCommand(c); }; });
}

void AddStereo(cli::Command& app, Command& c) {
  cli::Command* const euroc = AddFormat(app, "euroc", "EuRoC MAV / ASL, stereo; IMU, wheels", c);
  euroc->WhenGiven(
      [&c] { c.read = [&c] { return ReadEuroc(c.common.source, {c.common.skip_missing}); }; });
  cli::Command* const kitti = AddFormat(app, "kitti", "KITTI odometry, grey stereo", c);
  kitti->WhenGiven(
      [&c] { c.read = [&c] { return ReadKitti(c.common.source, {c.common.skip_missing}); }; });
}

void AddCidSims(cli::Command& app, Command& c) {
  cli::Command* const cid = AddFormat(app, "cid-sims", "CID-SIMS: RGB-D, IMU, wheels", c);
  cid->AddOption("--mount", c.cid.mount, "camera mounting of the sequence: high or low");
  cid->AddOption("--calibration", c.cid.calibration,
                 "calibration file (calibration.yaml in SRC or the folder above)");
  cid->AddChoice<ImuMatrix>(
      "--imu-matrix", c.cid.imu_matrix,
      {{"auto", ImuMatrix::kAuto},
       {"imu-to-camera", ImuMatrix::kImuToCamera},
       {"camera-to-imu", ImuMatrix::kCameraToImu}},
      "meaning of T_ItoC: imu-to-camera, camera-to-imu, or auto: decided by the gyro");
  cid->WhenGiven([&c] {
    c.read = [&c] {
      c.options = " --mount " + c.cid.mount;
      c.cid.skip_missing = c.common.skip_missing;
      return ReadCidSims(c.common.source, c.cid);
    };
  });
}

void AddOpenLoris(cli::Command& app, Command& c) {
  cli::Command* const loris =
      AddFormat(app, "openloris", "OpenLORIS-Scene: RGB-D, IMU, wheels; also without images", c);
  cli::Option* const encoders =
      loris->AddOption("--encoders", c.loris.encoders,
                       "instead of odom.txt: the encoders' readings, lines `t left right` (ticks)");
  cli::Option* const ticks =
      loris->AddOption("--ticks-per-turn", c.loris.ticks_per_turn, "of a wheel, with --encoders")
          ->InRange(1.0, 1e9);
  encoders->Needs(ticks);
  ticks->Needs(encoders);
  loris->WhenGiven([&c] {
    c.read = [&c] {
      c.loris.skip_missing = c.common.skip_missing;
      return ReadOpenLoris(c.common.source, c.loris);
    };
  });
}

void AddOdometry(cli::Command& app, Command& c) {
  cli::Command* const odometry = AddFormat(
      app, "odometry", "wheels without images: SRC is a file of poses `t x y z qx qy qz qw`", c);
  odometry->AddOption("--imu", c.odometry.imu, "IMU file, lines `t wx wy wz [ax ay az]`");
  odometry->AddChoice<ImuColumns>(
      "--imu-columns", c.odometry.imu_columns,
      {{"gyro-accel", ImuColumns::kGyroAccel}, {"accel-gyro", ImuColumns::kAccelGyro}},
      "order of its columns: gyro-accel (default) or accel-gyro");
  odometry->AddOption("--ground-truth", c.odometry.ground_truth,
                      "ground truth of the body, lines `t x y z qx qy qz qw`");
  odometry->WhenGiven(
      [&c] { c.read = [&c] { return ReadOdometry(c.common.source, c.odometry); }; });
}

void AddBagTopics(cli::Command& rosbag, Command& c) {
  for (const auto& [name, value, text] :
       {std::tuple{"--stereo", &c.bag.topics.stereo, "topics of the eyes: LEFT,RIGHT"},
        {"--rgbd", &c.bag.topics.rgbd, "topics of image and aligned depth: IMAGE,DEPTH"},
        {"--odom", &c.bag.topics.odometry,
         "topic of the wheels: Odometry, JointState or Kobuki's SensorState"},
        {"--imu", &c.bag.topics.imu, "topic of the IMU, or GYRO,ACCELEROMETER"},
        {"--truth", &c.bag.topics.truth, "topic of the ground truth"}}) {
    rosbag.AddOption(name, *value, std::string(text) + " (default: found by type; none: left out)");
  }
  rosbag.AddOption("--truth-parent", c.bag.truth_parent, "ground truth of tf: its frame")
      ->ShowDefault();
  rosbag.AddOption("--truth-child", c.bag.truth_child, "ground truth of tf: the body")
      ->ShowDefault();
  for (const auto& [name, value, text] :
       {std::tuple{"--wheel-radius", &c.bag.wheel_radius_m, "m, where the odometry is JointState"},
        {"--track", &c.bag.track_m, "m between the wheels, with JointState or ticks"}}) {
    rosbag.AddOption(name, *value, text)->InRange(0.001, 10.0);
  }
}

void AddRosbag(cli::Command& app, Command& c) {
  cli::Command* const rosbag = AddFormat(
      app, "rosbag", "ROS 1 bag, rosbag2 (SQLite3, MCAP): stereo or RGB-D, IMU, wheels, tf", c,
      /*always_writes=*/false);
  AddBagTopics(*rosbag, c);
  rosbag->AddOption("--calibration", c.bag.robot_config,
                    "robot configuration (YAML) whose calibration is taken instead of the bag's");
  rosbag->AddOption("--cid-sims-calibration", c.bag.cid_sims_calibration,
                    "the same from a calibration file of CID-SIMS");
  rosbag->AddOption("--mount", c.bag.mount, "with it: camera mounting, high or low");
  rosbag->AddFlag("--list", c.list_bag, "only show the topics and which would be imported");
  rosbag->WhenGiven([&c] { c.read = [&c] { return ReadRosbag(c.common.source, c.bag); }; });
}

Result<Done> Run(Command& command) {
  if (command.list_bag) {
    const Result<std::string> list = ListRosbag(command.common.source, command.bag);
    if (!list) return list.error();
    std::fputs(list->c_str(), stdout);
    return Done{};
  }
  std::optional<SyntheticDrOptions> dr;
  if (!command.common.synthetic_dr.empty()) {
    const Result<SyntheticDrOptions> parsed = ParseSyntheticDr(command.common.synthetic_dr);
    if (!parsed) return parsed.error();
    dr = *parsed;
  }
  Result<Recording> recording = command.read();
  if (!recording) return recording.error();
  return Import(*std::move(recording), command.common, dr, command.options);
}

int Main(int argc, char** argv) {
  cli::Command app(
      "Turns a recording of a public data set into an LCM log and a robot configuration.\n"
      "Exit: 0 ok, 1 bad or unreadable source, 2 usage, 78 calibration that breaks a rule.");
  app.RequireCommands(1, 1);
  Command command;
  AddTum(app, command);
  AddStereo(app, command);
  AddCidSims(app, command);
  AddOpenLoris(app, command);
  AddOdometry(app, command);
  AddRosbag(app, command);
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  if (!command.list_bag) {
    if (command.common.log.empty()) return app.Missing("--out");
    if (command.common.config.empty()) return app.Missing("--config-out");
  }
  const Result<Done> done = Run(command);
  if (done) return kExitOk;
  std::fprintf(stderr, "gw-import: %s\n", done.error().message.c_str());
  return ExitCodeFor(done.error());
}

}  // namespace
}  // namespace gw::importer

int main(int argc, char** argv) {
  return gw::importer::Main(argc, argv);
}

// gw-import: recordings of public data sets as LCM logs with a robot configuration.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <tuple>

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

void AddCommonOptions(CLI::App& app, Arguments& a) {
  app.add_option("SRC", a.source,
                 "folder of the recording (rosbag: the file, or the folder of rosbag2)")
      ->required();
  app.add_option("--out", a.log, "LCM log to write")->required();
  app.add_option("--config-out", a.config, "robot configuration (YAML) to write")->required();
  app.add_flag("--skip-missing", a.skip_missing,
               "leave out and count frames whose image files are not there or cannot be read");
  app.add_option(
      "--dr-from-groundtruth", a.synthetic_dr,
      "add dead reckoning made from the ground truth: "
      "sigma_t=0.004,sigma_r=0.1deg,bias_t=0,bias_r=0deg,walk_t=0,walk_r=0deg,rate=100,"
      "seed=1 (sigma: m and deg or rad per 1/30 s; bias: per s; walk: per s and sqrt(s))");
  app.add_option("--ground-truth-out", a.ground_truth_out, "ground truth as a TUM trajectory");
  app.add_option("--frame", a.frame, "frame of --ground-truth-out: body or camera")
      ->transform(CLI::CheckedTransformer(std::map<std::string, TrajectoryFrame>{
          {"body", TrajectoryFrame::kBody}, {"camera", TrajectoryFrame::kCamera}}));
  app.add_option("--gyro-unit", a.imu.gyro_unit,
                 "unit of the gyro: auto (decided by the data), rad/s or deg/s")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, GyroUnit>{{"auto", GyroUnit::kAuto},
                                                                  {"rad/s", GyroUnit::kRadPerS},
                                                                  {"deg/s", GyroUnit::kDegPerS}}));
  app.add_option("--accel-unit", a.imu.accel_unit,
                 "unit of the accelerometer: auto (decided by the data), m/s2 or g")
      ->transform(CLI::CheckedTransformer(std::map<std::string, AccelUnit>{
          {"auto", AccelUnit::kAuto}, {"m/s2", AccelUnit::kMetrePerS2}, {"g", AccelUnit::kG}}));
  app.add_option("--imu-time-offset", a.imu.time_offset_s,
                 "s by which the IMU's clock is ahead of the other sensors'; taken off");
  app.add_flag("--no-check", a.no_check, "do not run gw-check on what was imported");
  app.add_flag("--json", a.json, "print the summary as JSON");
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

CLI::App* AddFormat(CLI::App& app, const std::string& name, const std::string& text,
                    Command& command) {
  CLI::App* const format = app.add_subcommand(name, text);
  AddCommonOptions(*format, command.common);
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

void AddTum(CLI::App& app, Command& c) {
  CLI::App* const tum =
      AddFormat(app, "tum", "TUM RGB-D, or a camera of your own in its layout", c);
  tum->add_option("--camera", c.tum.camera,
                  "preset of the camera: fr1, fr2 or fr3 (default: as the folder's name says)");
  tum->add_option("--intrinsics", c.intrinsics,
                  "instead of a preset: fx,fy,cx,cy or fx,fy,cx,cy,k1,k2,p1,p2,k3");
  tum->add_option("--depth-unit", c.depth_unit_m,
                  "metres per unit of the depth images: 0.001 for millimetres (default: TUM's "
                  "1/5000)")
      ->check(CLI::Range(1e-6, 0.1));
  tum->callback([&c] { c.read = [&c] { return ReadTumCommand(c); }; });
}

void AddStereo(CLI::App& app, Command& c) {
  CLI::App* const euroc = AddFormat(app, "euroc", "EuRoC MAV / ASL, stereo; IMU, wheels", c);
  euroc->callback(
      [&c] { c.read = [&c] { return ReadEuroc(c.common.source, {c.common.skip_missing}); }; });
  CLI::App* const kitti = AddFormat(app, "kitti", "KITTI odometry, grey stereo", c);
  kitti->callback(
      [&c] { c.read = [&c] { return ReadKitti(c.common.source, {c.common.skip_missing}); }; });
}

void AddCidSims(CLI::App& app, Command& c) {
  CLI::App* const cid = AddFormat(app, "cid-sims", "CID-SIMS: RGB-D, IMU, wheels", c);
  cid->add_option("--mount", c.cid.mount, "camera mounting of the sequence: high or low");
  cid->add_option("--calibration", c.cid.calibration,
                  "calibration file (calibration.yaml in SRC or the folder above)");
  cid->add_option("--imu-matrix", c.cid.imu_matrix,
                  "meaning of T_ItoC: imu-to-camera, camera-to-imu, or auto: decided by the gyro")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, ImuMatrix>{{"auto", ImuMatrix::kAuto},
                                           {"imu-to-camera", ImuMatrix::kImuToCamera},
                                           {"camera-to-imu", ImuMatrix::kCameraToImu}}));
  cid->callback([&c] {
    c.read = [&c] {
      c.options = " --mount " + c.cid.mount;
      c.cid.skip_missing = c.common.skip_missing;
      return ReadCidSims(c.common.source, c.cid);
    };
  });
}

void AddOpenLoris(CLI::App& app, Command& c) {
  CLI::App* const loris =
      AddFormat(app, "openloris", "OpenLORIS-Scene: RGB-D, IMU, wheels; also without images", c);
  CLI::Option* const encoders = loris->add_option(
      "--encoders", c.loris.encoders,
      "instead of odom.txt: the encoders' readings, lines `t left right` (ticks)");
  CLI::Option* const ticks =
      loris->add_option("--ticks-per-turn", c.loris.ticks_per_turn, "of a wheel, with --encoders")
          ->check(CLI::Range(1.0, 1e9));
  encoders->needs(ticks);
  ticks->needs(encoders);
  loris->callback([&c] {
    c.read = [&c] {
      c.loris.skip_missing = c.common.skip_missing;
      return ReadOpenLoris(c.common.source, c.loris);
    };
  });
}

void AddOdometry(CLI::App& app, Command& c) {
  CLI::App* const odometry = AddFormat(
      app, "odometry", "wheels without images: SRC is a file of poses `t x y z qx qy qz qw`", c);
  odometry->add_option("--imu", c.odometry.imu, "IMU file, lines `t wx wy wz [ax ay az]`");
  odometry
      ->add_option("--imu-columns", c.odometry.imu_columns,
                   "order of its columns: gyro-accel (default) or accel-gyro")
      ->transform(CLI::CheckedTransformer(std::map<std::string, ImuColumns>{
          {"gyro-accel", ImuColumns::kGyroAccel}, {"accel-gyro", ImuColumns::kAccelGyro}}));
  odometry->add_option("--ground-truth", c.odometry.ground_truth,
                       "ground truth of the body, lines `t x y z qx qy qz qw`");
  odometry->callback([&c] { c.read = [&c] { return ReadOdometry(c.common.source, c.odometry); }; });
}

void AddBagTopics(CLI::App& rosbag, Command& c) {
  for (const auto& [name, value, text] :
       {std::tuple{"--stereo", &c.bag.topics.stereo, "topics of the eyes: LEFT,RIGHT"},
        {"--rgbd", &c.bag.topics.rgbd, "topics of image and aligned depth: IMAGE,DEPTH"},
        {"--odom", &c.bag.topics.odometry,
         "topic of the wheels: Odometry, JointState or Kobuki's SensorState"},
        {"--imu", &c.bag.topics.imu, "topic of the IMU, or GYRO,ACCELEROMETER"},
        {"--truth", &c.bag.topics.truth, "topic of the ground truth"}}) {
    rosbag.add_option(name, *value,
                      std::string(text) + " (default: found by type; none: left out)");
  }
  rosbag.add_option("--truth-parent", c.bag.truth_parent, "ground truth of tf: its frame")
      ->capture_default_str();
  rosbag.add_option("--truth-child", c.bag.truth_child, "ground truth of tf: the body")
      ->capture_default_str();
  for (const auto& [name, value, text] :
       {std::tuple{"--wheel-radius", &c.bag.wheel_radius_m, "m, where the odometry is JointState"},
        {"--track", &c.bag.track_m, "m between the wheels, with JointState or ticks"}}) {
    rosbag.add_option(name, *value, text)->check(CLI::Range(0.001, 10.0));
  }
}

void AddRosbag(CLI::App& app, Command& c) {
  CLI::App* const rosbag = AddFormat(
      app, "rosbag", "ROS 1 bag, rosbag2 (SQLite3, MCAP): stereo or RGB-D, IMU, wheels, tf", c);
  AddBagTopics(*rosbag, c);
  rosbag->add_option("--calibration", c.bag.robot_config,
                     "robot configuration (YAML) whose calibration is taken instead of the bag's");
  rosbag->add_option("--cid-sims-calibration", c.bag.cid_sims_calibration,
                     "the same from a calibration file of CID-SIMS");
  rosbag->add_option("--mount", c.bag.mount, "with it: camera mounting, high or low");
  rosbag->add_flag("--list", c.list_bag, "only show the topics and which would be imported");
  rosbag->get_option("--out")->required(false);
  rosbag->get_option("--config-out")->required(false);
  rosbag->callback([&c, rosbag] {
    for (const char* output : {"--out", "--config-out"}) {
      if (!c.list_bag && rosbag->count(output) == 0) throw CLI::RequiredError(output);
    }
    c.read = [&c] { return ReadRosbag(c.common.source, c.bag); };
  });
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
  CLI::App app(
      "Turns a recording of a public data set into an LCM log and a robot configuration.\n"
      "Exit: 0 ok, 1 bad or unreadable source, 2 usage, 78 calibration that breaks a rule.");
  app.set_version_flag("--version", Version());
  app.require_subcommand(1);
  Command command;
  AddTum(app, command);
  AddStereo(app, command);
  AddCidSims(app, command);
  AddOpenLoris(app, command);
  AddOdometry(app, command);
  AddRosbag(app, command);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kExitOk : kExitUsage;
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

// gw-import: recordings of public data sets as LCM logs with a robot configuration.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "common/config/writer.h"
#include "common/core/exit_code.h"
#include "common/core/version.h"
#include "tools/data/files/json.h"
#include "tools/data/files/text_file.h"
#include "tools/data/import/cid_sims.h"
#include "tools/data/import/euroc.h"
#include "tools/data/import/kitti.h"
#include "tools/data/import/openloris.h"
#include "tools/data/import/rosbag.h"
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
};

void AddCommonOptions(CLI::App& app, Arguments& a) {
  app.add_option("SRC", a.source, "folder of the recording (rosbag: the file)")->required();
  app.add_option("--out", a.log, "LCM log to write")->required();
  app.add_option("--config-out", a.config, "robot configuration (YAML) to write")->required();
  app.add_flag("--skip-missing", a.skip_missing,
               "leave out and count frames whose image files are not there");
  app.add_option(
      "--dr-from-groundtruth", a.synthetic_dr,
      "add dead reckoning made from the ground truth: "
      "sigma_t=0.004,sigma_r=0.1deg,bias_t=0,bias_r=0deg,walk_t=0,walk_r=0deg,rate=100,"
      "seed=1 (sigma: m and deg or rad per 1/30 s; bias: per s; walk: per s and sqrt(s))");
  app.add_option("--ground-truth-out", a.ground_truth_out, "ground truth as a TUM trajectory");
  app.add_option("--frame", a.frame, "frame of --ground-truth-out: body or camera")
      ->transform(CLI::CheckedTransformer(std::map<std::string, TrajectoryFrame>{
          {"body", TrajectoryFrame::kBody}, {"camera", TrajectoryFrame::kCamera}}));
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

std::string Summary(const Recording& recording, const LogSummary& log, const Arguments& a) {
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
                            {"warnings", recording.warnings}});
  }
  std::string out = fmt::format("{}: {:.3f} s, {:.1f} MB, {} frames skipped\n", a.log, duration_s,
                                static_cast<double>(log.bytes) * 1e-6, recording.skipped_frames);
  for (const auto& [channel, count] : log.messages) {
    out += fmt::format("  {:<14} {}\n", channel, count);
  }
  return out;
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
  const Result<LogSummary> log = WriteLog(recording, a.log, ProgressLine());
  if (!log) return log.error();
  const Result<Done> config_written =
      tools::WriteTextFile(a.config, WriteRobotConfig(*config, ConfigText::kShort));
  if (!config_written) return config_written.error();
  if (!a.ground_truth_out.empty()) {
    const Result<Done> written =
        tools::WriteTextFile(a.ground_truth_out, GroundTruthText(recording, a.frame));
    if (!written) return written.error();
  }
  std::fputs(Summary(recording, *log, a).c_str(), stdout);
  return Done{};
}

int Main(int argc, char** argv) {
  CLI::App app(
      "Turns a recording of a public data set into an LCM log and a robot configuration.\n"
      "Exit: 0 ok, 1 bad or unreadable source, 2 usage, 78 calibration that breaks a rule.");
  app.set_version_flag("--version", Version());
  app.require_subcommand(1);
  Arguments a;
  std::function<Result<Recording>()> read;
  std::string options;  // of the format, for the log's note

  TumOptions tum_options;
  std::string intrinsics;
  CLI::App* const tum = app.add_subcommand("tum", "TUM RGB-D");
  AddCommonOptions(*tum, a);
  tum->add_option("--camera", tum_options.camera, "preset of the camera: fr1, fr2 or fr3 (fr1)");
  tum->add_option("--intrinsics", intrinsics,
                  "instead of a preset: fx,fy,cx,cy or fx,fy,cx,cy,k1,k2,p1,p2,k3");
  tum->callback([&] {
    read = [&]() -> Result<Recording> {
      if (!intrinsics.empty()) {
        const Result<PinholeIntrinsics> parsed = ParseIntrinsics(intrinsics);
        if (!parsed) return parsed.error();
        tum_options.intrinsics = *parsed;
      }
      options =
          intrinsics.empty() ? " --camera " + tum_options.camera : " --intrinsics " + intrinsics;
      tum_options.skip_missing = a.skip_missing;
      return ReadTum(a.source, tum_options);
    };
  });

  CLI::App* const euroc = app.add_subcommand("euroc", "EuRoC MAV / ASL, stereo");
  AddCommonOptions(*euroc, a);
  euroc->callback([&] { read = [&] { return ReadEuroc(a.source, {a.skip_missing}); }; });

  CLI::App* const kitti = app.add_subcommand("kitti", "KITTI odometry, grey stereo");
  AddCommonOptions(*kitti, a);
  kitti->callback([&] { read = [&] { return ReadKitti(a.source, {a.skip_missing}); }; });

  CidSimsOptions cid_options;
  CLI::App* const cid = app.add_subcommand("cid-sims", "CID-SIMS: RGB-D, IMU, wheels");
  AddCommonOptions(*cid, a);
  cid->add_option("--mount", cid_options.mount, "camera mounting of the sequence: high or low");
  cid->add_option("--calibration", cid_options.calibration,
                  "calibration file (calibration.yaml in SRC or the folder above)");
  cid->add_option("--imu-matrix", cid_options.imu_matrix,
                  "meaning of T_ItoC: imu-to-camera, camera-to-imu, or auto: decided by the gyro")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, ImuMatrix>{{"auto", ImuMatrix::kAuto},
                                           {"imu-to-camera", ImuMatrix::kImuToCamera},
                                           {"camera-to-imu", ImuMatrix::kCameraToImu}}));
  cid->callback([&] {
    read = [&] {
      options = " --mount " + cid_options.mount;
      cid_options.skip_missing = a.skip_missing;
      return ReadCidSims(a.source, cid_options);
    };
  });

  CLI::App* const loris =
      app.add_subcommand("openloris", "OpenLORIS-Scene: RGB-D, IMU, wheels; also without images");
  AddCommonOptions(*loris, a);
  loris->callback([&] { read = [&] { return ReadOpenLoris(a.source, {a.skip_missing}); }; });

  RosbagOptions bag_options;
  CLI::App* const rosbag = app.add_subcommand(
      "rosbag", HasRosbagSupport() ? "ROS 1 bag: RGB-D, IMU, odometry; topics as CID-SIMS has them"
                                   : "ROS 1 bag (this build has no support for it)");
  AddCommonOptions(*rosbag, a);
  rosbag->add_option("--left", bag_options.left, "topic of the images")->capture_default_str();
  rosbag->add_option("--depth", bag_options.depth, "topic of the aligned depth")
      ->capture_default_str();
  rosbag->add_option("--imu", bag_options.imu, "topic of the IMU")->capture_default_str();
  rosbag->add_option("--odom", bag_options.odometry, "topic of the odometry")
      ->capture_default_str();
  rosbag->add_option("--tf", bag_options.transforms, "topic of the transforms")
      ->capture_default_str();
  rosbag->add_option("--truth-parent", bag_options.truth_parent, "frame of the ground truth")
      ->capture_default_str();
  rosbag->add_option("--truth-child", bag_options.truth_child, "body in the ground truth")
      ->capture_default_str();
  rosbag->add_option("--calibration", bag_options.robot_config,
                     "robot configuration (YAML) whose calibration is the bag's");
  rosbag->add_option("--cid-sims-calibration", bag_options.cid_sims_calibration,
                     "instead: calibration file of CID-SIMS");
  rosbag->add_option("--mount", bag_options.mount, "with it: camera mounting, high or low");
  rosbag->callback([&] { read = [&] { return ReadRosbag(a.source, bag_options); }; });

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kExitOk : kExitUsage;
  }
  const auto run = [&]() -> Result<Done> {
    std::optional<SyntheticDrOptions> dr;
    if (!a.synthetic_dr.empty()) {
      const Result<SyntheticDrOptions> parsed = ParseSyntheticDr(a.synthetic_dr);
      if (!parsed) return parsed.error();
      dr = *parsed;
    }
    Result<Recording> recording = read();
    if (!recording) return recording.error();
    return Import(*std::move(recording), a, dr, options);
  };
  const Result<Done> done = run();
  if (done) return kExitOk;
  std::fprintf(stderr, "gw-import: %s\n", done.error().message.c_str());
  return ExitCodeFor(done.error());
}

}  // namespace
}  // namespace gw::importer

int main(int argc, char** argv) {
  return gw::importer::Main(argc, argv);
}

// gw-slam: one log in, trajectory and map out, as fast as the machine allows.

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>

#include "backend/journal/journal.h"
#include "common/cli/command.h"
#include "common/config/loader.h"
#include "common/core/exit_code.h"
#include "common/wire/channels.h"
#include "tools/data/files/text_file.h"
#include "tools/lab/slam/dr_report.h"
#include "tools/lab/slam/laps.h"
#include "tools/lab/slam/slam_grid.h"
#include "tools/lab/slam/slam_output.h"
#include "tools/lab/slam/slam_session.h"
#include "tools/lab/slam/variant.h"

namespace gw::tools {
namespace {

struct Arguments {
  std::string log;
  std::string config;
  std::string out;
  std::string variant;
  std::string frame = "body";
  std::string timing;
  std::string map_in;
  std::string map_out;
  std::string grid;
  bool localize_only = false;
  bool dr_only = false;
  int laps = 1;
  int seed = 0;
};

int Fail(const Error& error) {
  std::cerr << "gw-slam: " << error.message << "\n";
  return ExitCodeFor(error);
}

int64_t SteadyMicroseconds() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

// Progress, timing and memory go to stderr: they differ from run to run, the outputs must not.
class Stopwatch {
 public:
  // After each event: how long since the one before.
  void Event(bool image) {
    const auto now = std::chrono::steady_clock::now();
    if (image) {
      milliseconds_.push_back(std::chrono::duration<double, std::milli>(now - event_).count());
    }
    event_ = now;
  }
  void Progress(double done) {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::seconds(2)) return;
    last_ = now;
    std::fprintf(stderr, "gw-slam: %3.0f %% done, %zu images\n", 100.0 * done,
                 milliseconds_.size());
  }
  void Print() {
    if (milliseconds_.empty()) return;
    std::sort(milliseconds_.begin(), milliseconds_.end());
    const auto quantile = [this](double q) {
      return milliseconds_[static_cast<size_t>(q * static_cast<double>(milliseconds_.size() - 1))];
    };
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    std::fprintf(
        stderr,
        "gw-slam: %zu images; per image (front-end and inline back-end) median %.1f ms, p99 "
        "%.1f ms; peak memory %.0f MB\n",
        milliseconds_.size(), quantile(0.5), quantile(0.99),
        static_cast<double>(usage.ru_maxrss) / 1024.0);
  }

 private:
  std::vector<double> milliseconds_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point event_ = last_;
};

// What --map-in holds; and that --map-out can take a map, before the work is done.
Result<backend::LoadedMap> OpenMaps(const Arguments& arguments,
                                    const backend::FeatureSource& source) {
  if (arguments.localize_only && (arguments.map_in.empty() || !arguments.map_out.empty())) {
    return Error{ErrorCode::kInvalidArgument,
                 "--localize-only needs --map-in DIR and makes nothing for --map-out"};
  }
  if (!arguments.map_out.empty() && !backend::Generations(arguments.map_out).empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "--map-out " + arguments.map_out + " holds a map already; name another folder"};
  }
  if (arguments.map_in.empty()) return backend::LoadedMap();
  auto loaded = backend::LoadMapFor(arguments.map_in, source);
  if (loaded && !loaded->damage.empty()) {
    std::fprintf(stderr, "gw-slam: warning: %s\n", loaded->damage.c_str());
  }
  return loaded;
}

int RunDeadReckoning(const Arguments& arguments) {
  const Result<RobotConfig> config = LoadRobotConfig(arguments.config);
  if (!config) return Fail(config.error());
  auto log = process::EventLogReader::Open(arguments.log);
  if (!log) return Fail(log.error());
  Stopwatch stopwatch;
  const auto run = RunDrOnly(*log, *config, [&] {
    stopwatch.Progress(static_cast<double>(log->position()) /
                       static_cast<double>(std::max<int64_t>(log->size(), 1)));
  });
  if (!run) return Fail(run.error());
  if (run->poses.empty()) {
    return Fail({ErrorCode::kBadData,
                 arguments.log + ": dead reckoning gave no pose: no message of IMU or wheels that "
                                 "can be used; see gw-log info and the configuration's "
                                 "calibration.imu, calibration.wheel and dr_ekf.source"});
  }
  DrRunDescription description;
  description.log_name = std::filesystem::path(arguments.log).filename().string();
  description.frame = arguments.frame == "camera" ? OutputFrame::kCamera : OutputFrame::kBody;
  description.log_skipped_bytes = log->skipped_bytes();
  description.log_truncated = log->truncated();
  const DrMotion motion = MeasureMotion(*run, config->calibration);
  const WheelSum sum =
      SumWheels(run->wheels, DurationFromSeconds(config->calibration.wheel.time_offset_s));
  const DrVerdict verdict = JudgeDrRun(*run, motion, sum, *config, description);
  const Result<Done> written =
      WriteDrOutputs(arguments.out, *run, motion, sum, *config, description, verdict);
  if (!written) return Fail(written.error());
  std::fputs(VerdictText(verdict).c_str(), stdout);
  return kExitOk;
}

int Run(const Arguments& arguments) {
  Result<RobotConfig> config = LoadRobotConfig(arguments.config);
  if (!config) return Fail(config.error());
  if (!arguments.variant.empty()) {
    const auto applied = ApplyVariant(arguments.variant, &config->frontend);
    if (!applied) return Fail(applied.error());
  }
  const auto geometry = MakeCameraGeometry(config->calibration);
  if (!geometry) return Fail(geometry.error());
  backend::MapSession own = backend::MakeSession({}, geometry->rectified, config->frontend.orb);
  auto maps = OpenMaps(arguments, own.source);
  if (!maps) return Fail(maps.error());
  auto session = SlamSession::Create(
      *config, {std::move(maps->map), std::move(maps->pending),
                arguments.localize_only ? backend::MapUse::kFrozen : backend::MapUse::kGrow});
  if (!session) return Fail(session.error());

  if (!arguments.timing.empty()) session->MeasureTimes(SteadyMicroseconds);
  std::optional<SlamGrid> grid;
  if (!arguments.grid.empty()) grid.emplace(*config, *geometry).Follow(&*session);
  Stopwatch stopwatch;
  auto laps = RunLaps(arguments.log, arguments.laps, {.seed = arguments.seed, .span = {}},
                      &*session, [&](const process::LogEvent& event, double done) {
                        stopwatch.Event(event.channel == wire::kCamera);
                        stopwatch.Progress(done);
                      });
  if (!laps) return Fail(laps.error());
  stopwatch.Print();

  RunDescription run;
  run.log_name = std::filesystem::path(arguments.log).filename().string();
  run.variant = VariantName(config->frontend);
  run.seed = arguments.seed;
  run.frame = arguments.frame == "camera" ? OutputFrame::kCamera : OutputFrame::kBody;
  run.laps = std::move(*laps);
  if (run.laps.log.skipped_bytes > 0 || run.laps.log.truncated) {
    std::fprintf(stderr, "gw-slam: %s is damaged: %lld bytes skipped%s; see gw-log check\n",
                 arguments.log.c_str(), static_cast<long long>(run.laps.log.skipped_bytes),
                 run.laps.log.truncated ? ", last event cut off" : "");
  }
  for (const TimeStep& step : run.laps.log.time_steps) {
    std::fprintf(stderr, "gw-slam: warning: %s: %s\n", arguments.log.c_str(),
                 Describe(step).c_str());
  }
  if (session->frames().empty()) {
    return Fail({ErrorCode::kBadData,
                 arguments.log + ": no camera message that can be decoded; see gw-log info, or use "
                                 "--dr-only for dead reckoning alone"});
  }
  for (const DrFinding& found : session->dr_found()) {
    std::fprintf(stderr, "gw-slam: warning: dead reckoning: %s\n",
                 Describe(found, session->first_dr()).c_str());
  }
  const std::string dr_fault = session->dr_fault();
  if (!dr_fault.empty()) {
    std::fprintf(stderr, "gw-slam: warning: dead reckoning is wrong by a constant: %s\n",
                 dr_fault.c_str());
  }
  const std::string length_fault = session->length_fault();
  if (!length_fault.empty()) {
    std::fprintf(stderr, "gw-slam: warning: %s\n", length_fault.c_str());
  }
  const std::string view_fault = session->view_fault();
  if (!view_fault.empty()) std::fprintf(stderr, "gw-slam: warning: %s\n", view_fault.c_str());
  const Result<Done> written = WriteOutputs(arguments.out, *config, run, *session);
  if (!written) return Fail(written.error());
  if (!arguments.timing.empty()) {
    const auto timing = WriteTextFile(arguments.timing, TimingTable(*session));
    if (!timing) return Fail(timing.error());
  }
  if (!arguments.map_out.empty()) {
    own.begin = session->frames().front().utime;
    own.first_keyframe = {session->newest_before().value + 1};
    backend::LoadedMap content;
    content.map = session->mapper().map();
    content.sessions = std::move(maps->sessions);
    content.sessions.push_back(own);
    auto saved = backend::SaveMap(arguments.map_out, content);
    if (saved && grid) saved = grid->Save(arguments.map_out);
    if (!saved) return Fail(saved.error());
  }
  if (grid) {
    if (const auto saved = grid->Write(arguments.grid); !saved) return Fail(saved.error());
  }
  return kExitOk;
}

}  // namespace
}  // namespace gw::tools

int main(int argc, char** argv) {
  gw::tools::Arguments arguments;
  gw::cli::Command app(
      "One log in, trajectory, keyframes, per-frame table and report out. Same binary, log and "
      "configuration give the same bytes.");
  app.AddOption("log", arguments.log, "LCM event log")->Required();
  app.AddOption("--config", arguments.config, "robot YAML")->Required();
  app.AddOption("--out", arguments.out, "folder for the results")->Required();
  gw::cli::Option* const dr_only = app.AddFlag(
      "--dr-only", arguments.dr_only,
      "dead reckoning alone, no image is read: dr.tum, raw_wheels.tum (the wheels' own sum), "
      "dr_covariance.csv, report.json, and a verdict");
  app.AddOption(
         "--variant", arguments.variant,
         "where dead reckoning enters: none, da, pe, lba, full, switch, fixed:ALPHA; default: "
         "as the YAML says")
      ->Excludes(dr_only);
  app.AddOption("--seed", arguments.seed,
                "perturbs the start: the first 3 * SEED images are dropped (default 0: none)")
      ->InRange(0, 1000)
      ->Excludes(dr_only);
  app.AddOption("--laps", arguments.laps,
                "the log so many times in one run, the map kept (default 1)")
      ->InRange(1, 1000)
      ->Excludes(dr_only);
  app.AddOption("--map-in", arguments.map_in, "begin with the map in this folder")
      ->Excludes(dr_only);
  app.AddOption("--map-out", arguments.map_out, "write the map of the end into this new folder")
      ->Excludes(dr_only);
  app.AddOption("--grid", arguments.grid,
                "also make the floor map: map.yaml and map.pgm into this folder; with --map-out "
                "saved there too")
      ->Excludes(dr_only);
  app.AddFlag("--localize-only", arguments.localize_only,
              "never change the map of --map-in: no keyframes are made")
      ->Excludes(dr_only);
  app.AddOption("--timing", arguments.timing,
                "write the front-end's time per image to this CSV file; differs between runs")
      ->Excludes(dr_only);
  app.AddOption("--frame", arguments.frame, "pose in the trajectories: body or camera")
      ->OneOf({"body", "camera"});
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  return arguments.dr_only ? gw::tools::RunDeadReckoning(arguments) : gw::tools::Run(arguments);
}

// gw-slam: one log in, trajectory and map out, as fast as the machine allows.

#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <string>

#include "common/config/loader.h"
#include "common/core/exit_code.h"
#include "common/core/version.h"
#include "lcmtypes/wire/channels.h"
#include "tools/slam/slam_output.h"
#include "tools/slam/slam_session.h"

namespace gw::tools {
namespace {

struct Arguments {
  std::string log;
  std::string config;
  std::string out;
  std::string variant;
  std::string frame = "body";
};

int Fail(const Error& error) {
  std::cerr << "gw-slam: " << error.message << "\n";
  return ExitCodeFor(error);
}

// "fixed:ALPHA" sets the scale too. Empty: as the configuration says.
Result<Done> ApplyVariant(const std::string& text, FrontendConfig* config) {
  const std::pair<const char*, Variant> names[] = {
      {"none", Variant::kNone}, {"da", Variant::kDa},     {"pe", Variant::kPe},
      {"lba", Variant::kLba},   {"full", Variant::kFull}, {"switch", Variant::kSwitch}};
  if (text.empty()) return Done{};
  for (const auto& [name, variant] : names) {
    if (text == name) {
      config->variant = variant;
      return Done{};
    }
  }
  if (text.rfind("fixed:", 0) == 0) {
    char* end = nullptr;
    const double alpha = std::strtod(text.c_str() + 6, &end);
    if (end != text.c_str() + 6 && *end == '\0' && alpha >= 0 && alpha <= 1e12) {
      config->variant = Variant::kFixed;
      config->dr_weight.fixed_alpha = alpha;
      return Done{};
    }
  }
  return Error{ErrorCode::kInvalidArgument,
               "--variant " + text + ": use none, da, pe, lba, full, switch or fixed:ALPHA"};
}

std::string VariantName(const FrontendConfig& config) {
  const char* names[] = {"none", "da", "pe", "lba", "full", "fixed", "switch"};
  return names[static_cast<int>(config.variant)];
}

// Progress, timing and memory go to stderr: they differ from run to run, the outputs must not.
class Stopwatch {
 public:
  void Image(std::chrono::steady_clock::duration took) {
    milliseconds_.push_back(std::chrono::duration<double, std::milli>(took).count());
  }
  void Progress(int64_t position, int64_t size) {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::seconds(2)) return;
    last_ = now;
    std::fprintf(
        stderr, "gw-slam: %3.0f %% of the log, %zu images\n",
        100.0 * static_cast<double>(position) / static_cast<double>(std::max<int64_t>(size, 1)),
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
};

int Run(const Arguments& arguments) {
  Result<RobotConfig> config = LoadRobotConfig(arguments.config);
  if (!config) return Fail(config.error());
  if (const auto applied = ApplyVariant(arguments.variant, &config->frontend); !applied) {
    return Fail(applied.error());
  }
  auto session = SlamSession::Create(*config);
  if (!session) return Fail(session.error());
  auto log = process::EventLogReader::Open(arguments.log);
  if (!log) return Fail(log.error());

  Stopwatch stopwatch;
  while (const auto event = log->Next()) {
    const auto start = std::chrono::steady_clock::now();
    session->Process(*event);
    if (event->channel == wire::kCamera) stopwatch.Image(std::chrono::steady_clock::now() - start);
    stopwatch.Progress(log->position(), log->size());
  }
  if (log->error()) return Fail(*log->error());
  session->Finish();
  stopwatch.Print();

  RunDescription run;
  run.log_name = std::filesystem::path(arguments.log).filename().string();
  run.variant = VariantName(config->frontend);
  run.frame = arguments.frame == "camera" ? OutputFrame::kCamera : OutputFrame::kBody;
  run.skipped_bytes = log->skipped_bytes();
  run.truncated = log->truncated();
  if (run.skipped_bytes > 0 || run.truncated) {
    std::fprintf(stderr, "gw-slam: %s is damaged: %lld bytes skipped%s; see gw-log check\n",
                 arguments.log.c_str(), static_cast<long long>(run.skipped_bytes),
                 run.truncated ? ", last event cut off" : "");
  }
  if (session->frames().empty()) {
    return Fail({ErrorCode::kBadData,
                 arguments.log + ": no camera message that can be decoded; see gw-log info"});
  }
  const Result<Done> written = WriteOutputs(arguments.out, *config, run, *session);
  if (!written) return Fail(written.error());
  return kExitOk;
}

}  // namespace
}  // namespace gw::tools

int main(int argc, char** argv) {
  gw::tools::Arguments arguments;
  CLI::App app(
      "One log in, trajectory, keyframes, per-frame table and report out. Same binary, log and "
      "configuration give the same bytes.");
  app.set_version_flag("--version", gw::Version());
  app.add_option("log", arguments.log, "LCM event log")->required();
  app.add_option("--config", arguments.config, "robot YAML")->required();
  app.add_option("--out", arguments.out, "folder for the results")->required();
  app.add_option(
      "--variant", arguments.variant,
      "where dead reckoning enters: none, da, pe, lba, full, switch, fixed:ALPHA; default: "
      "as the YAML says");
  app.add_option("--frame", arguments.frame, "pose in the trajectories: body or camera")
      ->check(CLI::IsMember({"body", "camera"}));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? gw::kExitOk : gw::kExitUsage;
  }
  return gw::tools::Run(arguments);
}

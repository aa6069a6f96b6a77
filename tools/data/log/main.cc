// gw-log: looks into LCM logs, checks them, cuts pieces out of them, makes MCAP files of them.
#include <cstdio>
#include <filesystem>
#include <string>

#include "common/camera/camera_model.h"
#include "common/cli/command.h"
#include "common/config/loader.h"
#include "common/core/exit_code.h"
#include "tools/data/files/json.h"
#include "tools/data/foxglove/mcap_export.h"
#include "tools/data/log/cut.h"
#include "tools/data/log/inspect.h"

namespace gw::tools {
namespace {

int Fail(const Error& error) {
  std::fprintf(stderr, "gw-log: %s\n", error.message.c_str());
  return ExitCodeFor(error);
}

int Inspect(const std::string& log, InspectDepth depth, bool json) {
  const Result<LogReport> report = InspectLog(log, depth);
  if (!report) return Fail(report.error());
  const bool check = depth == InspectDepth::kDecode;
  if (json) {
    std::fputs(ReportJson(*report).c_str(), stdout);
  } else if (!check) {
    std::fputs(ReportText(*report).c_str(), stdout);
  } else {
    for (const std::string& problem : report->problems) std::printf("%s\n", problem.c_str());
    std::printf("%s: %s (%lld events)\n", log.c_str(), report->ok ? "ok" : "has problems",
                static_cast<long long>(report->events));
  }
  return check && !report->ok ? kExitFailed : kExitOk;
}

int Cut(const std::string& log, const std::string& span, const std::string& out, bool json) {
  const Result<SpanArgument> parsed = ParseSpan("T0:T1", span);
  if (!parsed) return Fail(parsed.error());
  const Result<CutSummary> cut = CutLog(log, parsed->span, out);
  if (!cut) return Fail(cut.error());
  if (cut->source_truncated || cut->source_skipped_bytes > 0) {
    std::fprintf(stderr, "gw-log: warning: %s is damaged; gw-log check says where\n", log.c_str());
  }
  if (json) {
    const Json summary = {{"log", out}, {"events", cut->events}, {"bytes", cut->bytes}};
    std::fputs(JsonLine(summary).c_str(), stdout);
  } else {
    std::printf("%s: %lld events, %.1f MB\n", out.c_str(), static_cast<long long>(cut->events),
                static_cast<double>(cut->bytes) * 1e-6);
  }
  return kExitOk;
}

int Export(const std::string& log, std::string config, const std::string& out) {
  if (config.empty()) {
    const auto beside = std::filesystem::path(log).replace_extension(".yaml");
    if (std::filesystem::exists(beside)) config = beside.string();
  }
  foxglove::TranslatorOptions options;
  if (!config.empty()) {
    const auto loaded = LoadRobotConfig(config);
    if (!loaded) return Fail(loaded.error());
    const auto camera = MakeCameraGeometry(loaded->calibration);
    if (!camera) return Fail(camera.error());
    options.camera = *camera;
  }
  const auto exported = foxglove::ExportMcap(log, options, out);
  if (!exported) return Fail(exported.error());
  std::printf("%s: %llu messages, %.1f MB\n", out.c_str(),
              static_cast<unsigned long long>(exported->messages),
              static_cast<double>(exported->bytes) * 1e-6);
  if (exported->undecodable > 0) {
    std::fprintf(stderr, "gw-log: warning: %lld messages of %s could not be decoded\n",
                 static_cast<long long>(exported->undecodable), log.c_str());
  }
  return kExitOk;
}

int Main(int argc, char** argv) {
  cli::Command app(
      "Looks into LCM logs, checks them, cuts pieces out of them, makes MCAP files of them.\n"
      "Exit: 0 ok, 1 problems found or file not readable, 2 usage.");
  app.RequireCommands(1, 1);
  std::string log, span, out, mcap, config;
  bool json = false;
  cli::Command* const info = app.AddCommand("info", "channels, rates, gaps, duration, notes");
  cli::Command* const check = app.AddCommand(
      "check", "lost messages, time order, undecodable messages, damage; exit 1 when any");
  cli::Command* const cut = app.AddCommand("cut", "copy a span of time into a new log");
  cli::Command* const exporting =
      app.AddCommand("export", "what gw-view shows of it, as an MCAP file for other viewers");
  for (cli::Command* const command : {info, check, cut, exporting}) {
    command->AddOption("LOG", log, "LCM log")->Required();
  }
  for (cli::Command* const command : {info, check, cut}) {
    command->AddFlag("--json", json, "print JSON");
  }
  exporting->AddOption("--mcap", mcap, "file to write")->Required();
  exporting->AddOption("--config", config,
                       "robot YAML, for the camera; default: the one beside LOG");
  cut->AddOption("SPAN", span, "T0:T1, seconds from the begin of the log")->Required();
  cut->AddOption("OUT", out, "log to write")->Required();
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  if (info->given()) return Inspect(log, InspectDepth::kHeaders, json);
  if (check->given()) return Inspect(log, InspectDepth::kDecode, json);
  if (exporting->given()) return Export(log, config, mcap);
  return Cut(log, span, out, json);
}

}  // namespace
}  // namespace gw::tools

int main(int argc, char** argv) {
  return gw::tools::Main(argc, argv);
}

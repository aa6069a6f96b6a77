// gw-check: the health of a recording on one page, before anyone trusts a trajectory of it.
#include <cstdio>
#include <string>

#include "common/cli/command.h"
#include "common/config/loader.h"
#include "common/core/exit_code.h"
#include "tools/lab/check/check_log.h"

namespace gw::check {
namespace {

int Main(int argc, char** argv) {
  std::string log, config_file;
  bool json = false, lines = false, no_vision = false;
  cli::Command app(
      "Says what is wrong with a recording: stamps, images, IMU, wheels, and each against the "
      "others.\nExit: 0 no errors found, 1 errors found or unreadable, 2 usage, 78 bad "
      "configuration.");
  app.AddOption("LOG", log, "LCM log")->Required();
  app.AddOption("--config", config_file, "robot configuration (YAML)")->Required();
  app.AddFlag("--no-vision", no_vision,
              "do not follow the images (seconds instead of the time gw-slam takes): scales, "
              "delays and mounting are not checked against vision");
  auto* const json_flag = app.AddFlag("--json", json, "print the findings as JSON");
  app.AddFlag("--lines", lines,
              "print the findings alone, one a line: severity, id, text, fix between tabs")
      ->Excludes(json_flag);
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  const auto fail = [](const Error& error) {
    std::fprintf(stderr, "gw-check: %s\n", error.message.c_str());
    return ExitCodeFor(error);
  };
  const Result<RobotConfig> config = LoadRobotConfig(config_file);
  if (!config) return fail(config.error());
  const Result<Report> report = CheckLog(log, *config, !no_vision);
  if (!report) return fail(report.error());
  const std::string text = json    ? ReportJson(*report)
                           : lines ? ReportLines(*report)
                                   : ReportText(*report);
  std::fputs(text.c_str(), stdout);
  for (const Finding& finding : report->findings) {
    if (finding.severity == Severity::kError) return kExitFailed;
  }
  return kExitOk;
}

}  // namespace
}  // namespace gw::check

int main(int argc, char** argv) {
  return gw::check::Main(argc, argv);
}

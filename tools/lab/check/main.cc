// gw-check: the health of a recording on one page, before anyone trusts a trajectory of it.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "common/config/loader.h"
#include "common/core/exit_code.h"
#include "common/core/version.h"
#include "tools/lab/check/check_log.h"

namespace gw::check {
namespace {

int Main(int argc, char** argv) {
  std::string log, config_file;
  bool json = false, lines = false, no_vision = false;
  CLI::App app(
      "Says what is wrong with a recording: stamps, images, IMU, wheels, and each against the "
      "others.\nExit: 0 no errors found, 1 errors found or unreadable, 2 usage, 78 bad "
      "configuration.");
  app.set_version_flag("--version", Version());
  app.add_option("LOG", log, "LCM log")->required();
  app.add_option("--config", config_file, "robot configuration (YAML)")->required();
  app.add_flag("--no-vision", no_vision,
               "do not follow the images (seconds instead of the time gw-slam takes): scales, "
               "delays and mounting are not checked against vision");
  auto* const json_flag = app.add_flag("--json", json, "print the findings as JSON");
  app.add_flag("--lines", lines,
               "print the findings alone, one a line: severity, id, text, fix between tabs")
      ->excludes(json_flag);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kExitOk : kExitUsage;
  }
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

// gw-study: the figures of Du, Peng, Vela, "Good Weights", arXiv 2509.22910, localisation in a map,
// its loops, and faults, one command each.
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "common/cli/command.h"
#include "common/core/exit_code.h"
#include "tools/lab/study/study.h"

namespace gw::study {
namespace {

struct Command {
  const char* name;
  const char* help;
  std::unique_ptr<Study> (*make)();
};

constexpr Command kCommands[] = {
    {"quality", "pose error of vision against N_det and N_trk", MakeQualityStudy},
    {"alpha-sweep", "pose error against a fixed scale of the DR information", MakeAlphaSweepStudy},
    {"latency", "tracking time with and without Good Weights", MakeLatencyStudy},
    {"repeat-run", "the same way lap after lap, the map kept", MakeRepeatRunStudy},
    {"localize", "starts in a saved map, and the robot carried about in it", MakeLocalizeStudy},
    {"loops", "are the loops of a drive closed, and does that make the map better", MakeLoopsStudy},
    {"closed-loop", "a robot drives several ways on live poses", MakeClosedLoopStudy},
    {"dr-faults", "faults of wheels, IMU and extrinsics, one after the other", MakeDrFaultsStudy},
    {"vision-faults", "faults of the camera, one after the other", MakeVisionFaultsStudy},
    {"real-wheels", "the odometry of real robots under a rendered camera", MakeRealWheelsStudy},
};

int Main(int argc, char** argv) {
  cli::Command app(
      "The paper's studies, localisation in a map, its loops, and faults. Each writes NAME.md, "
      "NAME.csv,\n"
      "NAME.svg and the report of all, NAME.html, and prints the first.\n"
      "Exit: 0 ok, 1 failed, 2 usage, 78 bad configuration.");
  app.RequireCommands(1, 1);
  std::string out;
  std::vector<std::unique_ptr<Study>> studies;
  std::vector<cli::Command*> commands;
  for (const Command& command : kCommands) {
    cli::Command* const sub = app.AddCommand(command.name, command.help);
    sub->AddOption("--out", out, "folder for the files")->Required();
    commands.push_back(sub);
    studies.push_back(command.make());
    studies.back()->AddOptions(*sub);
  }
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  for (size_t i = 0; i < studies.size(); ++i) {
    const Command& command = kCommands[i];
    if (!commands[i]->given()) continue;
    const auto files = studies[i]->Run();
    const Result<Done> done =
        files ? WriteStudy(out, command.name, *files) : Result<Done>(files.error());
    if (!done) {
      std::fprintf(stderr, "gw-study %s: %s\n", command.name, done.error().message.c_str());
      return ExitCodeFor(done.error());
    }
    std::fputs(files->markdown.c_str(), stdout);
  }
  return kExitOk;
}

}  // namespace
}  // namespace gw::study

int main(int argc, char** argv) {
  return gw::study::Main(argc, argv);
}

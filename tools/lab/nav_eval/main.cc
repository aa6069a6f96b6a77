// gw-nav-eval: how well a tour of gw-navigate was driven.
#include <cstdio>
#include <string>

#include "common/cli/command.h"
#include "common/core/exit_code.h"
#include "tools/data/files/json.h"
#include "tools/lab/nav_eval/closed_loop.h"

namespace gw::navigate {
namespace {

Result<Done> Run(const std::string& folder, const std::string& truth_path, bool json) {
  const auto record = ReadTourRecord(folder);
  if (!record) return record.error();
  const auto truth = eval::ReadReference(truth_path);
  if (!truth) return truth.error();
  const auto result = Evaluate(*record, *truth);
  if (!result) return result.error();
  const ClosedLoop& r = *result;
  if (json) {
    const tools::Json report = {{"stops", r.stops},
                                {"reached", r.reached},
                                {"accuracy_m", r.accuracy_m},
                                {"accuracy_rad", r.accuracy_rad},
                                {"precision_waypoints", r.precision_waypoints},
                                {"precision_m", r.precision_m},
                                {"precision_rad", r.precision_rad},
                                {"est_rmse_m", r.est_rmse_m},
                                {"nav_rmse_m", r.nav_rmse_m}};
    std::fputs(tools::JsonLine(report).c_str(), stdout);
    return Done{};
  }
  std::printf("stops reached          %d of %d\n", r.reached, r.stops);
  std::printf("accuracy of the stops  %.3f m  %.3f rad\n", r.accuracy_m, r.accuracy_rad);
  if (r.precision_waypoints > 0) {
    std::printf("precision              %.4f m  %.4f rad  (%d waypoints)\n", r.precision_m,
                r.precision_rad, r.precision_waypoints);
  }
  std::printf("est-RMSE               %.3f m\n", r.est_rmse_m);
  std::printf("nav-RMSE               %.3f m\n", r.nav_rmse_m);
  return Done{};
}

}  // namespace
}  // namespace gw::navigate

int main(int argc, char** argv) {
  std::string folder, truth;
  bool json = false;
  gw::cli::Command app(
      "How well a tour was driven: accuracy and precision of the stops, est-RMSE, nav-RMSE.\n"
      "Exit: 0 ok, 1 files not usable, 2 usage.");
  app.AddOption("--record", folder, "folder that gw-navigate --record wrote")->Required();
  app.AddOption("--truth", truth, "true poses in the map: TUM file, or LCM log (.lcm)")->Required();
  app.AddFlag("--json", json, "print JSON");
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  const auto done = gw::navigate::Run(folder, truth, json);
  if (done) return gw::kExitOk;
  std::fprintf(stderr, "gw-nav-eval: %s\n", done.error().message.c_str());
  return gw::ExitCodeFor(done.error());
}

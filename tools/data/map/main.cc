// gw-map: looks into the map on disk, checks it, repairs it, and gives it to other programs.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "backend/journal/journal.h"
#include "common/core/exit_code.h"
#include "common/core/version.h"
#include "grid/files/map_server.h"
#include "tools/data/files/text_file.h"
#include "tools/data/map/map_export.h"
#include "tools/data/map/map_report.h"

namespace gw::tools {
namespace {

int Fail(const Error& error) {
  std::fprintf(stderr, "gw-map: %s\n", error.message.c_str());
  return ExitCodeFor(error);
}

Result<backend::LoadedMap> Load(const std::string& directory) {
  auto loaded = backend::LoadMap(directory);
  if (loaded && loaded->generation == 0) {
    return Error{ErrorCode::kNotFound, directory + ": holds no map"};
  }
  if (loaded && !loaded->damage.empty()) {
    std::fprintf(stderr, "gw-map: warning: %s\n", loaded->damage.c_str());
  }
  return loaded;
}

int Info(const std::string& directory, bool json) {
  const auto loaded = Load(directory);
  if (!loaded) return Fail(loaded.error());
  const MapReport report = Describe(directory, *loaded);
  std::fputs((json ? ReportJson(report) : ReportText(report)).c_str(), stdout);
  return kExitOk;
}

int Check(const std::string& directory, bool json) {
  const auto report = CheckDirectory(directory);
  if (!report) return Fail(report.error());
  if (json) {
    std::fputs(ReportJson(*report).c_str(), stdout);
  } else {
    for (const std::string& problem : report->problems) std::printf("%s\n", problem.c_str());
    std::printf("%s: %s (%lld keyframes, %lld landmarks)\n", directory.c_str(),
                report->problems.empty() ? "ok" : "has problems",
                static_cast<long long>(report->keyframes),
                static_cast<long long>(report->landmarks));
  }
  return report->problems.empty() ? kExitOk : kExitFailed;
}

int Repair(const std::string& directory, const std::string& out) {
  const auto loaded = Load(directory);
  if (!loaded) return Fail(loaded.error());
  const backend::MapFaults faults = backend::CheckMap(loaded->map);
  if (faults.count > 0) {
    std::fprintf(stderr, "gw-map: %s: the map contradicts itself in %lld places, first: %s\n",
                 directory.c_str(), static_cast<long long>(faults.count), faults.texts[0].c_str());
    return kExitFailed;
  }
  if (const auto saved = backend::SaveMap(out, *loaded); !saved) return Fail(saved.error());
  std::printf("%s: %zu keyframes, %zu landmarks, revision %lld; %s is as it was\n", out.c_str(),
              loaded->map.keyframes().size() + loaded->pending.size(), loaded->map.num_landmarks(),
              static_cast<long long>(loaded->map.revision()), directory.c_str());
  return kExitOk;
}

struct ExportFiles {
  std::string ply, g2o, tum, grid;
  int min_shared = 15;
};

Result<Done> ExportFloor(const std::string& directory, const backend::LoadedMap& loaded,
                         const std::string& out) {
  auto saved = grid::LoadGrid(directory);
  if (!saved && saved.error().code == ErrorCode::kNotFound) {
    return Error{ErrorCode::kNotFound,
                 saved.error().message + ": the map was made without gw-grid (or gw-slam --grid)"};
  }
  if (!saved) return saved.error();
  return grid::WriteMapServer(out, FloorOf(loaded, *std::move(saved)));
}

int Export(const std::string& directory, const ExportFiles& files) {
  if (files.ply.empty() && files.g2o.empty() && files.tum.empty() && files.grid.empty()) {
    return Fail(
        {ErrorCode::kInvalidArgument, "export: name a file with --ply, --g2o, --tum or --grid"});
  }
  const auto loaded = Load(directory);
  if (!loaded) return Fail(loaded.error());
  const auto write = [](const std::string& path, const auto& make) -> Result<Done> {
    if (path.empty()) return Done{};
    return WriteTextFile(path, make());
  };
  Result<Done> done = write(files.ply, [&] { return PlyText(*loaded); });
  if (done) done = write(files.g2o, [&] { return G2oText(*loaded, files.min_shared); });
  if (done) {
    done = write(files.tum, [&] {
      TumKeyframes keyframes = TumText(*loaded);
      if (keyframes.left_out > 0) {
        std::fprintf(stderr, "gw-map: %lld keyframes left out of %s: a newer one has their time\n",
                     static_cast<long long>(keyframes.left_out), files.tum.c_str());
      }
      return std::move(keyframes.text);
    });
  }
  if (done && !files.grid.empty()) done = ExportFloor(directory, *loaded, files.grid);
  return done ? kExitOk : Fail(done.error());
}

int Main(int argc, char** argv) {
  CLI::App app(
      "Looks into the map on disk (gw-backend --map DIR), checks it, repairs it, exports it.\n"
      "Exit: 0 ok, 1 problems found or map not readable, 2 usage.");
  app.set_version_flag("--version", Version());
  app.require_subcommand(1);
  std::string directory, out;
  bool json = false;
  ExportFiles files;
  CLI::App* const info = app.add_subcommand("info", "keyframes, landmarks, sessions, size");
  CLI::App* const check =
      app.add_subcommand("check", "every checksum, every invariant of the map; exit 1 if broken");
  CLI::App* const repair = app.add_subcommand(
      "repair", "the newest consistent map into a new folder; DIR stays as it is");
  CLI::App* const to_files = app.add_subcommand("export", "the map for other programs");
  for (CLI::App* const command : {info, check, repair, to_files}) {
    command->add_option("DIR", directory, "folder of the map")->required();
  }
  for (CLI::App* const command : {info, check}) command->add_flag("--json", json, "print JSON");
  repair->add_option("--out", out, "new folder")->required();
  to_files->add_option("--ply", files.ply, "landmarks and way of the robot, for a mesh viewer");
  to_files->add_option("--g2o", files.g2o, "pose graph: dead-reckoning and covisibility edges");
  to_files->add_option("--tum", files.tum, "keyframes as t tx ty tz qx qy qz qw of the body");
  to_files->add_option("--grid", files.grid,
                       "folder for the floor map of gw-grid: map.yaml and map.pgm of map_server");
  to_files
      ->add_option("--min-shared", files.min_shared,
                   "g2o: common landmarks that make a covisibility edge (default 15)")
      ->check(CLI::Range(1, 1000000));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kExitOk : kExitUsage;
  }
  if (*info) return Info(directory, json);
  if (*check) return Check(directory, json);
  if (*repair) return Repair(directory, out);
  return Export(directory, files);
}

}  // namespace
}  // namespace gw::tools

int main(int argc, char** argv) {
  return gw::tools::Main(argc, argv);
}

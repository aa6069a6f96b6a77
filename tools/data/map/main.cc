// gw-map: looks into the map on disk, checks it, repairs it, edits it, joins two, and gives it to
// other programs.
#include <cstdio>
#include <string>

#include "backend/journal/journal.h"
#include "common/cli/command.h"
#include "common/core/exit_code.h"
#include "grid/files/map_server.h"
#include "tools/data/files/text_file.h"
#include "tools/data/map/map_edit.h"
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

// The map with its floor map, for editing.
Result<SavedMap> LoadSaved(const std::string& directory) {
  auto loaded = Load(directory);
  if (!loaded) return loaded.error();
  SavedMap out{*std::move(loaded), std::nullopt};
  auto saved = grid::LoadGrid(directory);
  if (saved) {
    out.grid = *std::move(saved);
  } else if (saved.error().code != ErrorCode::kNotFound) {
    std::fprintf(stderr, "gw-map: warning: the floor map is left out: %s\n",
                 saved.error().message.c_str());
  }
  return out;
}

// Writes an edited map, which has to be whole, into a new folder.
int Save(const Result<EditedMap>& edited, const std::string& out) {
  if (!edited) return Fail(edited.error());
  const backend::MapFaults faults = backend::CheckMap(edited->saved.map.map);
  if (faults.count > 0) {
    return Fail({ErrorCode::kBadData, "the new map would contradict itself: " + faults.texts[0]});
  }
  if (const auto saved = backend::SaveMap(out, edited->saved.map); !saved) {
    return Fail(saved.error());
  }
  if (edited->saved.grid) {
    if (const auto saved = grid::SaveGrid(out, *edited->saved.grid); !saved) {
      return Fail(saved.error());
    }
  }
  for (const std::string& note : edited->notes) std::printf("%s\n", note.c_str());
  std::printf("%s: %zu keyframes, %zu landmarks\n", out.c_str(),
              edited->saved.map.map.keyframes().size(), edited->saved.map.map.num_landmarks());
  return kExitOk;
}

int Merge(const std::string& directory, const std::string& second, const std::string& out) {
  const auto a = LoadSaved(directory);
  if (!a) return Fail(a.error());
  const auto b = LoadSaved(second);
  if (!b) return Fail(b.error());
  return Save(MergeSavedMaps(*a, *b), out);
}

int WithoutSession(const std::string& directory, int session, const std::string& out) {
  const auto saved = LoadSaved(directory);
  if (!saved) return Fail(saved.error());
  return Save(RemoveSession(*saved, session), out);
}

int Crop(const std::string& directory, const std::string& rectangle, const std::string& out) {
  const auto parsed = ParseRectangle(rectangle);
  if (!parsed) return Fail(parsed.error());
  const auto saved = LoadSaved(directory);
  if (!saved) return Fail(saved.error());
  return Save(CropMap(*saved, *parsed), out);
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

// What the command line says.
struct Arguments {
  std::string directory, second, out, rectangle;
  int session = 0;
  bool json = false;
  ExportFiles files;
};

struct Commands {
  cli::Command *info, *check, *repair, *merge, *remove_session, *crop, *to_files;
};

Commands AddCommands(cli::Command* app, Arguments* arguments) {
  Commands c{};
  c.info = app->AddCommand("info", "keyframes, landmarks, sessions, size");
  c.check =
      app->AddCommand("check", "every checksum, every invariant of the map; exit 1 if broken");
  c.repair =
      app->AddCommand("repair", "the newest consistent map into a new folder; DIR stays as it is");
  c.merge = app->AddCommand(
      "merge",
      "two maps made apart become one where they show the same places; exit 1 if they do "
      "not, 78 if their cameras differ");
  c.remove_session =
      app->AddCommand("remove-session", "the map without the keyframes of one session");
  c.crop = app->AddCommand("crop", "the part of the map inside a rectangle");
  c.to_files = app->AddCommand("export", "the map for other programs");
  for (cli::Command* const command :
       {c.info, c.check, c.repair, c.merge, c.remove_session, c.crop, c.to_files}) {
    command->AddOption("DIR", arguments->directory, "folder of the map")->Required();
  }
  c.merge->AddOption("SECOND", arguments->second, "folder of the map to be joined to it")
      ->Required();
  for (cli::Command* const command : {c.info, c.check}) {
    command->AddFlag("--json", arguments->json, "print JSON");
  }
  for (cli::Command* const command : {c.repair, c.merge, c.remove_session, c.crop}) {
    command->AddOption("--out", arguments->out, "new folder; what is given stays as it is")
        ->Required();
  }
  c.remove_session->AddOption("--session", arguments->session, "its number, as info lists them")
      ->Required();
  c.crop
      ->AddOption("--rectangle", arguments->rectangle,
                  "x0,y0,x1,y1 in W, metres: keyframes "
                  "whose body is inside stay")
      ->Required();
  return c;
}

void AddExportOptions(cli::Command* command, ExportFiles* files) {
  command->AddOption("--ply", files->ply, "landmarks and way of the robot, for a mesh viewer");
  command->AddOption("--g2o", files->g2o, "pose graph: dead-reckoning and covisibility edges");
  command->AddOption("--tum", files->tum, "keyframes as t tx ty tz qx qy qz qw of the body");
  command->AddOption("--grid", files->grid,
                     "folder for the floor map of gw-grid: map.yaml and map.pgm of map_server");
  command
      ->AddOption("--min-shared", files->min_shared,
                  "g2o: common landmarks that make a covisibility edge (default 15)")
      ->InRange(1, 1000000);
}

int Main(int argc, char** argv) {
  cli::Command app(
      "Looks into the map on disk (gw-backend --map DIR), checks it, repairs it, edits it, exports "
      "it.\n"
      "Exit: 0 ok, 1 problems found or map not usable, 2 usage, 78 maps of different cameras.");
  app.RequireCommands(1, 1);
  Arguments arguments;
  const Commands commands = AddCommands(&app, &arguments);
  AddExportOptions(commands.to_files, &arguments.files);
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  const std::string& directory = arguments.directory;
  if (commands.info->given()) return Info(directory, arguments.json);
  if (commands.check->given()) return Check(directory, arguments.json);
  if (commands.repair->given()) return Repair(directory, arguments.out);
  if (commands.merge->given()) return Merge(directory, arguments.second, arguments.out);
  if (commands.remove_session->given())
    return WithoutSession(directory, arguments.session, arguments.out);
  if (commands.crop->given()) return Crop(directory, arguments.rectangle, arguments.out);
  return Export(directory, arguments.files);
}

}  // namespace
}  // namespace gw::tools

int main(int argc, char** argv) {
  return gw::tools::Main(argc, argv);
}

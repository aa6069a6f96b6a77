#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>

#include "backend/core/mapper.h"
#include "backend/journal/journal.h"
#include "backend/test/world.h"
#include "common/core/exit_code.h"
#include "tools/data/map/map_edit.h"
#include "tools/data/map/map_export.h"
#include "tools/data/map/map_report.h"

namespace gw::tools {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A folder with a map of two sessions, driven in a small world.
class MapToolTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    directory_ = fs::path(testing::TempDir()) /
                 ("gw_map_" + std::string(test->name()) + "_" + std::to_string(getpid()));
    fs::remove_all(directory_);
    backend::World world({.num_points = 300, .keyframes_per_lap = 160});
    backend::Mapper mapper = *backend::Mapper::Create({}, {}, backend::TestCamera());
    for (const int until : {4, 9}) {
      backend::LoadedMap loaded;
      auto journal = *backend::Journal::Open(
          Path("map"), {}, backend::MakeSession({1'000'000}, backend::TestCamera(), OrbConfig()),
          loaded);
      while (next_ < until) {
        const Keyframe keyframe = world.Make(next_++, mapper.map());
        ASSERT_TRUE(journal.Append(keyframe, {}).ok());
        ASSERT_TRUE(journal.Append(*mapper.Insert(keyframe).update, {}).ok());
        if (const auto job = mapper.BuildJob()) {
          const auto update = mapper.Apply(SolveLocalBa(*job));
          ASSERT_TRUE(update);
          ASSERT_TRUE(journal.Append(*update, {}).ok());
        }
      }
    }
  }
  void TearDown() override { fs::remove_all(directory_); }

  std::string Path(const std::string& name) const { return (directory_ / name).string(); }
  std::string Journal() const { return backend::GenerationPath(Path("map"), 1); }
  static std::string Read(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void Damage(std::ptrdiff_t from_end) const {
    std::fstream file(Journal(), std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(-from_end, std::ios::end);
    file.put('\x5A').put('\x5A').put('\x5A');
  }
  // Exit code; what the program says is in output().
  int Run(const std::string& arguments) const {
    const std::string command =
        GW_BINARY_DIR "/gw-map " + arguments + " > " + Path("output") + " 2>&1";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string output() const { return Read(Path("output")); }

  fs::path directory_;
  int next_ = 0;
};

TEST_F(MapToolTest, DescribesSessionsAndSizes) {
  const auto loaded = backend::LoadMap(Path("map"));
  const MapReport report = Describe(Path("map"), *loaded);
  EXPECT_EQ(report.keyframes, 9);
  ASSERT_EQ(report.sessions.size(), 2u);
  EXPECT_EQ(report.sessions[0].keyframes, 4);
  EXPECT_EQ(report.sessions[1].keyframes, 5);
  EXPECT_GT(report.sessions[1].first_utime, report.sessions[0].last_utime);
  EXPECT_EQ(report.file_bytes, static_cast<int64_t>(fs::file_size(Journal())));
  EXPECT_EQ(report.landmarks, static_cast<int64_t>(loaded->map.num_landmarks()));
  EXPECT_TRUE(report.problems.empty());
  EXPECT_THAT(ReportJson(report), HasSubstr("\"keyframes\":9,"));
  backend::LoadedMap copy;
  copy.map = loaded->map;
  // The size stated is that of the file the map would make.
  ASSERT_TRUE(backend::SaveMap(Path("copy"), copy).ok());
  EXPECT_NEAR(9 * report.bytes_per_keyframe,
              static_cast<double>(fs::file_size(backend::GenerationPath(Path("copy"), 1))), 1);
}

TEST_F(MapToolTest, CheckFindsDamageInAnyGenerationAndSaysWhere) {
  EXPECT_EQ(Run("check " + Path("map")), kExitOk) << output();
  EXPECT_THAT(output(), HasSubstr("ok (9 keyframes"));
  const auto loaded = backend::LoadMap(Path("map"));
  const auto sound = CheckDirectory(Path("map"));
  EXPECT_TRUE(sound->problems.empty()) << testing::PrintToString(sound->problems);
  Damage(300);
  EXPECT_EQ(Run("check " + Path("map")), kExitFailed);
  EXPECT_THAT(output(), HasSubstr("map-00000001.gwj at byte"));
  EXPECT_EQ(Run("check --json " + Path("map")), kExitFailed);
  EXPECT_THAT(output(), HasSubstr("\"problems\":[\""));
}

TEST_F(MapToolTest, RepairMakesAWholeMapAndLeavesTheOldOne) {
  Damage(300);
  const std::string before = Read(Journal());
  ASSERT_EQ(Run("repair " + Path("map") + " --out " + Path("new")), kExitOk) << output();
  EXPECT_EQ(Read(Journal()), before);
  EXPECT_EQ(Run("check " + Path("new")), kExitOk) << output();
  const auto damaged = backend::LoadMap(Path("map"));
  const auto repaired = backend::LoadMap(Path("new"));
  EXPECT_EQ(repaired->map.Hash(), damaged->map.Hash());
  EXPECT_EQ(repaired->sessions.size(), 2u);
  // Never over a map that is there.
  EXPECT_EQ(Run("repair " + Path("map") + " --out " + Path("new")), kExitFailed);
  EXPECT_THAT(output(), HasSubstr("holds a map already"));
}

TEST_F(MapToolTest, ExportsPlyG2oAndTum) {
  ASSERT_EQ(Run("export " + Path("map") + " --ply " + Path("a.ply") + " --g2o " + Path("a.g2o") +
                " --tum " + Path("a.tum") + " --min-shared 5"),
            kExitOk)
      << output();
  const auto loaded = backend::LoadMap(Path("map"));
  EXPECT_THAT(Read(Path("a.ply")),
              HasSubstr("element vertex " + std::to_string(loaded->map.num_landmarks() + 9)));
  EXPECT_THAT(Read(Path("a.ply")), HasSubstr("element edge 8\n"));
  std::istringstream tum(Read(Path("a.tum")));
  double last = -1, t = 0, skip = 0;
  int lines = 0;
  while (tum >> t >> skip >> skip >> skip >> skip >> skip >> skip >> skip) {
    EXPECT_GT(t, last);
    last = t;
    ++lines;
  }
  EXPECT_EQ(lines, 9);
}

// The pose graph is at rest where the map is: covisibility edges agree with the vertices, DR edges
// nearly.
TEST_F(MapToolTest, TheG2oEdgesConnectTheVertices) {
  const auto loaded = backend::LoadMap(Path("map"));
  std::istringstream g2o(G2oText(*loaded, 5));
  std::map<int, SE3> vertices;
  int dr_edges = 0, covisibility_edges = 0;
  const auto pose = [](std::istream& in) {
    Eigen::Vector3d p;
    Eigen::Quaterniond q;
    in >> p.x() >> p.y() >> p.z() >> q.x() >> q.y() >> q.z() >> q.w();
    return SE3(q, p);
  };
  std::string line;
  while (std::getline(g2o, line)) {
    std::istringstream words(line);
    std::string kind;
    int id = 0, to = 0;
    words >> kind >> id;
    if (kind == "VERTEX_SE3:QUAT") {
      vertices[id] = pose(words);
      continue;
    }
    ASSERT_EQ(kind, "EDGE_SE3:QUAT");
    words >> to;
    const SE3 T_FromTo = pose(words);
    double information = 0;
    int numbers = 0;
    while (words >> information) ++numbers;
    EXPECT_EQ(numbers, 21);
    const double error =
        ((vertices.at(id).inverse() * vertices.at(to)).inverse() * T_FromTo).Log().norm();
    ++(error < 1e-6 ? covisibility_edges : dr_edges);
    EXPECT_LT(error, 0.1) << line;
  }
  EXPECT_EQ(vertices.size(), 9u);
  EXPECT_EQ(dr_edges, 8);
  EXPECT_GT(covisibility_edges, 8);
}

// A local grid hangs on its keyframe: the floor map shows it where that is now.
TEST_F(MapToolTest, ExportsTheFloorMapThatIsSavedBesideTheMap) {
  const std::string export_grid = "export " + Path("map") + " --grid " + Path("floor");
  EXPECT_EQ(Run(export_grid), kExitFailed);
  EXPECT_THAT(output(), HasSubstr("made without gw-grid"));

  const auto loaded = backend::LoadMap(Path("map"));
  const auto& [id, keyframe] = *loaded->map.keyframes().begin();
  const SE3 T_WB = keyframe.frame.T_WC * loaded->sessions[0].T_BC.inverse();
  grid::GridFile file{0.05, {{id, keyframe.frame.utime, {}}}};
  file.grids[0].grid.cells.Add({20, 0}, {3, 1});  // 1.025 m ahead of the keyframe
  ASSERT_TRUE(grid::SaveGrid(Path("map"), file).ok());
  const grid::FloorImage image = FloorOf(*loaded, file);
  const auto occupied = std::find(image.cells.begin(), image.cells.end(), CellState::kOccupied);
  ASSERT_NE(occupied, image.cells.end());
  const auto at = static_cast<int>(occupied - image.cells.begin());
  const Eigen::Vector3d expected = T_WB * Eigen::Vector3d(1.025, 0.025, 0);
  EXPECT_NEAR((image.first_x + at % image.width + 0.5) * 0.05, expected.x(), 0.08);
  EXPECT_NEAR((image.first_y + at / image.width + 0.5) * 0.05, expected.y(), 0.08);

  EXPECT_EQ(Run(export_grid), kExitOk) << output();
  EXPECT_THAT(Read(Path("floor/map.yaml")), HasSubstr("resolution: 0.05"));
}

// Local grids on three keyframes, beside the map.
TEST_F(MapToolTest, ASessionIsTakenOutAndTheFloorMapFollows) {
  grid::GridFile file{0.05, {}};
  for (const int64_t id : {2, 5, 7}) {
    file.grids.push_back({{id}, {}, {}});
    file.grids.back().grid.cells.Add({20, 0}, {3, 1});
  }
  ASSERT_TRUE(grid::SaveGrid(Path("map"), file).ok());
  const std::string before = Read(Journal());
  ASSERT_EQ(Run("remove-session " + Path("map") + " --session 2 --out " + Path("one")), kExitOk)
      << output();
  EXPECT_THAT(output(), HasSubstr("4 of 9 keyframes"));
  EXPECT_THAT(output(), HasSubstr("1 of 3 local grids"));
  EXPECT_EQ(Read(Journal()), before);
  EXPECT_EQ(Run("check " + Path("one")), kExitOk) << output();
  const auto one = backend::LoadMap(Path("one"));
  EXPECT_EQ(one->sessions.size(), 1u);
  EXPECT_EQ(one->map.keyframes().rbegin()->first, KeyframeId{4});
  EXPECT_EQ(grid::LoadGrid(Path("one"))->grids.size(), 1u);

  EXPECT_EQ(Run("remove-session " + Path("map") + " --session 3 --out " + Path("x")), kExitFailed);
  EXPECT_THAT(output(), HasSubstr("sessions 1 to 2"));
  EXPECT_EQ(Run("remove-session " + Path("one") + " --session 1 --out " + Path("x")), kExitFailed);
  EXPECT_THAT(output(), HasSubstr("nothing would be left"));
  // Never over a map that is there.
  EXPECT_EQ(Run("remove-session " + Path("map") + " --session 1 --out " + Path("one")),
            kExitFailed);
  EXPECT_EQ(Run("remove-session " + Path("map") + " --out " + Path("x")), kExitUsage);
}

TEST_F(MapToolTest, CropKeepsWhatLiesInside) {
  const auto loaded = backend::LoadMap(Path("map"));
  const Eigen::Vector3d p = BodyPose(*loaded, loaded->map.FindKeyframe({4})->frame).translation();
  const Rectangle around{p.x() - 0.05, p.y() - 0.05, p.x() + 0.05, p.y() + 0.05};
  const auto cropped = CropMap({*loaded, std::nullopt}, around);
  ASSERT_TRUE(cropped.ok());
  EXPECT_NE(cropped->saved.map.map.FindKeyframe({4}), nullptr);
  EXPECT_LT(cropped->saved.map.map.keyframes().size(), loaded->map.keyframes().size());
  EXPECT_EQ(Run("crop " + Path("map") + " --rectangle -100,-100,100,100 --out " + Path("all")),
            kExitOk)
      << output();
  EXPECT_EQ(Run("check " + Path("all")), kExitOk) << output();
  EXPECT_THAT(output(), HasSubstr("ok (9 keyframes"));
  EXPECT_EQ(Run("crop " + Path("map") + " --rectangle 50,50,60,60 --out " + Path("x")),
            kExitFailed);
  EXPECT_THAT(output(), HasSubstr("no keyframe"));
  for (const char* bad : {"1,2,3", "1,2,0,4", "1,2,3,4,5", "a,b,c,d", "1,2,nan,4", "1;2;3;4"}) {
    EXPECT_EQ(Run("crop " + Path("map") + " --out " + Path("x") + " --rectangle '" + bad + "'"),
              kExitUsage)
        << bad;
  }
}

// A part of a lap through a furnished room, on disk; by vision alone.
void SaveDrive(const std::string& directory, uint64_t seed) {
  backend::World world({.seed = seed, .keyframes_per_lap = 40});
  backend::LoadedMap drive;
  backend::Mapper mapper = *backend::Mapper::Create({}, {}, backend::TestCamera());
  for (int k = 0; k < 12; ++k) {
    Keyframe keyframe = world.Make(k, mapper.map());
    keyframe.dr.reset();
    mapper.Insert(keyframe);
  }
  drive.map = mapper.map();
  drive.sessions = {backend::MakeSession({1'000'000}, backend::TestCamera(), OrbConfig())};
  ASSERT_TRUE(backend::SaveMap(directory, drive).ok());
}

double Length(const backend::Map& map, KeyframeId from, KeyframeId to) {
  return (map.FindKeyframe(from)->frame.T_WC.translation() -
          map.FindKeyframe(to)->frame.T_WC.translation())
      .norm();
}

// Poses and landmarks, not what the features tell.
void Stretch(double by, backend::Map* map) {
  std::set<LandmarkId> seen;
  for (const auto& [id, keyframe] : map->keyframes()) {
    const SE3& T_WC = keyframe.frame.T_WC;
    map->SetPose(id, SE3(T_WC.rotation(), by * T_WC.translation()));
    seen.insert(keyframe.frame.landmarks.begin(), keyframe.frame.landmarks.end());
  }
  seen.erase(LandmarkId{});
  for (const LandmarkId id : seen) map->MutableLandmark(id).p_W *= by;
}

TEST_F(MapToolTest, MapsAreMergedOrTheReasonIsTold) {
  ASSERT_NO_FATAL_FAILURE(SaveDrive(Path("a"), 1));
  ASSERT_NO_FATAL_FAILURE(SaveDrive(Path("other"), 2));
  const std::string merge = "merge " + Path("a") + " ";
  EXPECT_EQ(Run(merge + Path("nowhere") + " --out " + Path("x")), kExitFailed);
  EXPECT_THAT(output(), HasSubstr("holds no map"));
  // The same drive twice: certainly the same place.
  ASSERT_EQ(Run(merge + Path("a") + " --out " + Path("both")), kExitOk) << output();
  EXPECT_THAT(output(), HasSubstr("views of the second map agree"));
  EXPECT_EQ(Run("check " + Path("both")), kExitOk) << output();
  const auto both = backend::LoadMap(Path("both"));
  ASSERT_EQ(both->sessions.size(), 2u);
  EXPECT_EQ(both->sessions[1].first_keyframe, KeyframeId{13});
  const auto one = backend::LoadMap(Path("a"));
  EXPECT_LT(both->map.num_landmarks(), one->map.num_landmarks() * 3 / 2);

  EXPECT_EQ(Run(merge + Path("other") + " --out " + Path("x")), kExitFailed);
  EXPECT_THAT(output(), HasSubstr("no place in common"));
  EXPECT_FALSE(fs::exists(Path("x")));
  backend::LoadedMap another_camera = *one;
  another_camera.sessions.back().source.fx += 1;
  ASSERT_TRUE(backend::SaveMap(Path("camera"), another_camera).ok());
  EXPECT_EQ(Run(merge + Path("camera") + " --out " + Path("x")), kExitBadConfig);
  EXPECT_THAT(output(), HasSubstr("different cameras: fx"));
}

TEST_F(MapToolTest, DisparitiesHoldTheLengthsOfMergedMaps) {
  ASSERT_NO_FATAL_FAILURE(SaveDrive(Path("a"), 1));
  backend::LoadedMap drive = *backend::LoadMap(Path("a"));
  const double length = Length(drive.map, KeyframeId{1}, KeyframeId{12});
  Stretch(1.02, &drive.map);  // two per cent more than the features' disparities say
  ASSERT_TRUE(backend::SaveMap(Path("long"), drive).ok());
  ASSERT_EQ(Run("merge " + Path("long") + " " + Path("long") + " --out " + Path("both")), kExitOk)
      << output();
  const auto both = backend::LoadMap(Path("both"));
  EXPECT_NEAR(Length(both->map, KeyframeId{1}, KeyframeId{12}), length, 0.005 * length);
}

TEST_F(MapToolTest, ExitCodesTellUsageFromData) {
  EXPECT_EQ(Run("info " + Path("nowhere")), kExitFailed);
  EXPECT_THAT(output(), HasSubstr("holds no map"));
  EXPECT_EQ(Run("export " + Path("map")), kExitUsage);
  EXPECT_EQ(Run("repair " + Path("map")), kExitUsage);
  EXPECT_EQ(Run(""), kExitUsage);
  EXPECT_EQ(Run("info --json " + Path("map")), kExitOk);
}

}  // namespace
}  // namespace gw::tools

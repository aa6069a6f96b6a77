#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "common/core/random.h"
#include "grid/files/grid_file.h"
#include "grid/files/map_server.h"
#include "grid/files/whole_file.h"

namespace gw::grid {
namespace {

using testing::HasSubstr;

std::string Folder(const std::string& name) {
  const auto folder = std::filesystem::path(testing::TempDir()) /
                      ("gw_grid_" + name + "_" + std::to_string(getpid()));
  std::filesystem::remove_all(folder);
  return folder.string();
}

GridFile SomeGrid() {
  GridFile file{0.05, {}};
  for (int64_t id : {3, 17}) {
    GridMap::SavedGrid& saved = file.grids.emplace_back();
    saved.keyframe = {id};
    saved.keyframe_utime = Utime{id * 1000};
    saved.grid.T_KL = Pose2({0.1 * static_cast<double>(id), -2}, 0.3);
    CounterRng rng(1, 2, static_cast<uint64_t>(id));
    for (const Index2 tile : {Index2{-1, 4}, Index2{2, -7}}) {
      for (Cell& cell : saved.grid.cells.Make(tile)) {
        cell.log_odds = static_cast<float>(static_cast<int>(rng.Below(150)) - 60) / 32;
        cell.sharpness = static_cast<float>(rng.Below(250)) / 25;
      }
    }
  }
  return file;
}

TEST(GridFile, GivesBackWhatWasSaved) {
  const std::string folder = Folder("round_trip");
  const GridFile file = SomeGrid();
  ASSERT_TRUE(SaveGrid(folder, file).ok());
  const auto loaded = LoadGrid(folder);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message;
  ASSERT_EQ(loaded->grids.size(), file.grids.size());
  EXPECT_EQ(loaded->cell_m, file.cell_m);
  for (size_t i = 0; i < file.grids.size(); ++i) {
    EXPECT_EQ(loaded->grids[i].keyframe, file.grids[i].keyframe);
    EXPECT_EQ(loaded->grids[i].keyframe_utime, file.grids[i].keyframe_utime);
    EXPECT_EQ(loaded->grids[i].grid.cells.tiles(), file.grids[i].grid.cells.tiles());
    EXPECT_EQ(loaded->grids[i].grid.T_KL.translation(), file.grids[i].grid.T_KL.translation());
  }
  std::filesystem::remove_all(folder);
}

TEST(GridFile, EveryDamageIsNoticed) {
  const std::vector<uint8_t> good = EncodeGrid(SomeGrid());
  ASSERT_TRUE(DecodeGrid(good).ok());
  for (size_t at = 0; at < good.size(); at += 7) {
    std::vector<uint8_t> bad = good;
    bad[at] ^= 0x10;
    EXPECT_FALSE(DecodeGrid(bad).ok()) << at;
  }
  for (size_t length = 0; length < good.size(); length += 11) {
    EXPECT_FALSE(DecodeGrid({good.begin(), good.begin() + static_cast<ptrdiff_t>(length)}).ok());
  }
}

TEST(GridFile, SaysWhichFileIsBad) {
  const std::string folder = Folder("bad");
  EXPECT_EQ(LoadGrid(folder).error().code, ErrorCode::kNotFound);
  std::filesystem::create_directories(folder);
  const std::string text = "not a grid";
  ASSERT_TRUE(WriteWholeFile(folder + "/" + kGridFileName,
                             {reinterpret_cast<const uint8_t*>(text.data()), text.size()})
                  .ok());
  EXPECT_THAT(LoadGrid(folder).error().message, HasSubstr("grid.gwg: grid: not a file of grids"));
  std::filesystem::remove_all(folder);
}

TEST(MapServer, WritesWhiteFloorBlackWallsGreyRest) {
  const std::string folder = Folder("map_server");
  FloorImage image{0.05, -3, 2, 3, 2, {}};
  image.cells = {CellState::kFree,     CellState::kOccupied, CellState::kUnknown,
                 CellState::kOccupied, CellState::kFree,     CellState::kFree};
  ASSERT_TRUE(WriteMapServer(folder, image).ok());
  const auto pgm = *ReadWholeFile(folder + "/map.pgm");
  const std::string header = "P5\n3 2\n255\n";
  ASSERT_EQ(pgm.size(), header.size() + 6);
  EXPECT_EQ(std::string(pgm.begin(), pgm.begin() + static_cast<ptrdiff_t>(header.size())), header);
  // The upper row of the picture has the higher y.
  EXPECT_EQ(std::vector<uint8_t>(pgm.begin() + static_cast<ptrdiff_t>(header.size()), pgm.end()),
            (std::vector<uint8_t>{0, 254, 254, 254, 0, 205}));
  const auto yaml = *ReadWholeFile(folder + "/map.yaml");
  const std::string text(yaml.begin(), yaml.end());
  EXPECT_THAT(text, HasSubstr("resolution: 0.05\n"));
  EXPECT_THAT(text, HasSubstr("image: map.pgm\n"));
  EXPECT_THAT(text, HasSubstr("negate: 0\n"));
  std::filesystem::remove_all(folder);
}

TEST(MapServer, NothingSeenIsAnError) {
  EXPECT_EQ(WriteMapServer(Folder("nothing"), {}).error().code, ErrorCode::kBadData);
}

TEST(WholeFile, AFolderThatCannotBeWrittenIsAnErrorThatNamesIt) {
  EXPECT_THAT(WriteWholeFile("/proc/no/such", {}).error().message, HasSubstr("/proc/no/such"));
}

}  // namespace
}  // namespace gw::grid

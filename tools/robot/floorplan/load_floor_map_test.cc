#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "grid/files/map_server.h"
#include "tools/robot/floorplan/floor_map.h"

namespace gw::floorplan {
namespace {

using ::testing::HasSubstr;

class FloorMapFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("floor_map_" +
               std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string Write(const std::string& name, const std::string& content) {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return (folder_ / name).string();
  }
  // map.yaml with one of its lines replaced, or a line more.
  std::string Yaml(const std::string& key = "", const std::string& value = "") {
    std::vector<std::pair<std::string, std::string>> lines = {
        {"image", "map.pgm"}, {"resolution", "0.5"},       {"origin", "[-1, 2, 0]"},
        {"negate", "0"},      {"occupied_thresh", "0.65"}, {"free_thresh", "0.196"}};
    bool known = key.empty();
    for (auto& [name, text] : lines) {
      if (name != key) continue;
      text = value;
      known = true;
    }
    if (!known) lines.emplace_back(key, value);
    std::string text;
    for (const auto& [name, line] : lines) text.append(name).append(": ").append(line).append("\n");
    return Write("map.yaml", text);
  }
  // The cells of a map as letters, the upper row first: # wall, ? unknown, . free.
  static std::string Letters(const std::string& yaml) {
    const auto map = LoadFloorMap(yaml);
    if (!map) return map.error().message;
    std::string out;
    for (int y = map->height - 1; y >= 0; --y) {
      for (int x = 0; x < map->width; ++x) {
        out += map->Occupied(x, y) ? '#' : map->Unknown(x, y) ? '?' : '.';
      }
      out += y > 0 ? "/" : "";
    }
    return out;
  }
  std::filesystem::path folder_;
};

TEST_F(FloorMapFile, TheFirstRowOfTheImageIsTheTopOfTheMap) {
  Write("map.pgm", "P2\n# a comment\n3 2 # of cells\n255\n0 254 205 # unknown\n254 254 0\n");
  const std::string yaml = Yaml();
  EXPECT_EQ(Letters(yaml), "#.?/..#");
  EXPECT_EQ(LoadFloorMap(yaml)->CellOf({-0.9, 2.6}), Eigen::Vector2i(0, 1));
}

TEST_F(FloorMapFile, TheGreyOfMapSaversIsUnknownWhateverFreeThreshSays) {
  Write("map.pgm", "P2\n5 1\n255\n0 254 205 206 204\n");
  EXPECT_EQ(Letters(Yaml("free_thresh", "0.196")), "#.?.?");
  EXPECT_EQ(Letters(Yaml("free_thresh", "0.25")), "#.?..");
}

TEST_F(FloorMapFile, ThresholdsAndNegateReadTheGreyAsMapServerDoes) {
  Write("map.pgm", "P2\n6 1\n255\n0 51 89 90 230 255\n");
  EXPECT_EQ(Letters(Yaml()), "###?..");
  EXPECT_EQ(Letters(Yaml("occupied_thresh", "0.9")), "#???..");
  EXPECT_EQ(Letters(Yaml("free_thresh", "0.05")), "###??.");
  EXPECT_EQ(Letters(Yaml("negate", "1")), ".???##");
  EXPECT_EQ(Letters(Yaml("negate", "true")), ".???##");
  EXPECT_EQ(Letters(Yaml("mode", "scale")), "###?..");
  EXPECT_EQ(Letters(Yaml("mode", "trinary")), "###?..");
}

TEST_F(FloorMapFile, RawGreyIsOccupancyInPerCent) {
  Write("map.pgm", "P2\n7 1\n255\n0 19 20 66 100 101 255\n");
  EXPECT_EQ(Letters(Yaml("mode", "raw")), "..?##??");
  Write("map.yaml",
        "image: map.pgm\nresolution: 1\norigin: [0, 0, 0]\noccupied_thresh: 0.65\nmode: raw\n"
        "negate: 1\n");
  EXPECT_THAT(Letters((folder_ / "map.yaml").string()), HasSubstr("map.yaml:6: negate"));
}

TEST_F(FloorMapFile, AMapOfWallsAloneDoesNotTellFreeFromUnknown) {
  Write("map.pgm", "P2\n3 1\n255\n0 205 205\n");
  EXPECT_EQ(Letters(Yaml()), "#..");
}

TEST_F(FloorMapFile, PgmIsReadWithAnyWhiteBinaryAndText) {
  Write("map.pgm", "P2 4 1 15 0 15 8 12");
  EXPECT_EQ(Letters(Yaml()), "#.??") << "8 of 15 is 136, 12 of 15 is 204";
  Write("map.pgm", std::string("P5\n4 1\n15\n") + std::string("\x00\x0f\x08\x0d", 4));
  EXPECT_EQ(Letters(Yaml()), "#.?.");
  Write("map.pgm", std::string("P5\n2 1\n65535\n") + std::string("\x00\xff\xff\xff", 4));
  EXPECT_EQ(Letters(Yaml()), "#.");
}

TEST_F(FloorMapFile, PngMayHaveColourAlphaAndSixteenBits) {
  const auto save = [this](const cv::Mat& image) {
    ASSERT_TRUE(cv::imwrite((folder_ / "map.png").string(), image));
  };
  cv::Mat alpha(1, 4, CV_8UC4, cv::Scalar(254, 254, 254, 255));
  alpha.at<cv::Vec4b>(0, 0) = {0, 0, 0, 255};
  alpha.at<cv::Vec4b>(0, 1)[3] = 0;
  alpha.at<cv::Vec4b>(0, 2)[3] = 254;
  save(alpha);
  EXPECT_EQ(Letters(Yaml("image", "map.png")), "#??.");
  cv::Mat colour(1, 2, CV_8UC3, cv::Scalar(255, 254, 253));
  colour.at<cv::Vec3b>(0, 0) = {0, 90, 30};
  save(colour);
  EXPECT_EQ(Letters(Yaml("image", "map.png")), "#.");
  cv::Mat deep(1, 3, CV_16U, cv::Scalar(65535));
  deep.at<uint16_t>(0, 0) = 1;
  deep.at<uint16_t>(0, 1) = 205 * 257;
  save(deep);
  EXPECT_EQ(Letters(Yaml("image", "map.png")), "#?.");
}

TEST_F(FloorMapFile, AnOriginWithAYawTurnsTheMapAboutItsCorner) {
  Write("map.pgm", "P2\n3 2\n255\n0 254 205\n254 254 0\n");
  EXPECT_EQ(Letters(Yaml("origin", "[-1, 2, 1.5707963267948966]")), "?#/../#.");
  const auto map = LoadFloorMap(Yaml("origin", "[-1, 2, 1.5707963267948966]"));
  EXPECT_LT((map->origin - Eigen::Vector2d(-2, 2)).norm(), 1e-9);
  EXPECT_EQ(Letters(Yaml("origin", "[-1, 2, 6.283185307179586]")), "#.?/..#");
}

TEST_F(FloorMapFile, ATurnedMapKeepsItsPlacesAndItsWallsHaveNoGaps) {
  // A room of 40 x 30 cells with walls one cell thick.
  std::string pgm = "P2\n40 30\n255\n";
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      pgm += x % 39 == 0 || y % 29 == 0 ? "0 " : "254 ";
    }
  }
  Write("map.pgm", pgm);
  for (const double degrees : {3.0, 30.0, 45.0, 200.0, -77.0}) {
    const double yaw = degrees * std::numbers::pi / 180;
    const auto map = LoadFloorMap(Yaml("origin", "[-1, 2, " + std::to_string(yaw) + "]"));
    ASSERT_TRUE(map.ok()) << map.error().message;
    const auto place = [&](double x, double y) {
      return Eigen::Vector2d(-1 + x * std::cos(yaw) - y * std::sin(yaw),
                             2 + x * std::sin(yaw) + y * std::cos(yaw));
    };
    const auto cell = [&](double x, double y) { return map->CellOf(place(x, y)); };
    EXPECT_TRUE(map->Occupied(cell(0.25, 7.3).x(), cell(0.25, 7.3).y())) << degrees;
    EXPECT_FALSE(map->Occupied(cell(10, 7.3).x(), cell(10, 7.3).y())) << degrees;
    EXPECT_FALSE(map->Unknown(cell(10, 7.3).x(), cell(10, 7.3).y())) << degrees;
    const auto inside = ReachableCells(*map, place(10, 7.3));
    const double area = std::count(inside.begin(), inside.end(), 1) * 0.25;
    EXPECT_LT(area, 19 * 14) << degrees << ": leaks through a wall";
    EXPECT_GT(area, 18 * 13) << degrees;
  }
}

TEST_F(FloorMapFile, TheImageMayBeGivenByAnAbsolutePath) {
  const std::string image = Write("elsewhere.pgm", "P2\n2 1\n255\n0 254\n");
  EXPECT_EQ(Letters(Yaml("image", "\"" + image + "\"")), "#.");
}

TEST_F(FloorMapFile, FilesFromWindowsAreRead) {
  Write("map.pgm", "P2\r\n2 1\r\n255\r\n0 254\r\n");
  const std::string yaml =
      Write("map.yaml",
            "\xEF\xBB\xBFimage: map.pgm\r\nresolution: 0.5\r\norigin: [0, 0, 0]\r\n"
            "negate: 0\r\noccupied_thresh: 0.65\r\nfree_thresh: 0.196\r\n");
  EXPECT_EQ(Letters(yaml), "#.");
}

TEST_F(FloorMapFile, BadImagesAreErrorsThatNameThem) {
  EXPECT_EQ(LoadFloorMap((folder_ / "none.yaml").string()).error().code, ErrorCode::kNotFound);
  const std::string yaml = Yaml();
  EXPECT_THAT(Letters(yaml), HasSubstr("map.pgm: cannot open"));
  for (const char* text :
       {"P5\n3 2\n255\nab", "P2\n0 0\n255\n", "P2\n3 1\n255\n0 254", "P2\n3 1\n0\n0 254 0\n",
        "P2\n-3 1\n255\n0 254 0\n", "P2\n900000 900000\n255\n0", "P2\n3 1\n70000\n0 1 2", "",
        "P2\n3 1\n255\n0 x 1\n", "P6\n3 2\n255\nabc", "no image"}) {
    Write("map.pgm", text);
    EXPECT_THAT(Letters(yaml), HasSubstr("map.pgm: not an image")) << text;
  }
  Write("map.pgm", "P2\n2 1\n255\n254 254\n");
  EXPECT_THAT(Letters(yaml), HasSubstr("map without walls"));
}

TEST_F(FloorMapFile, EveryMistakeOfTheYamlIsNamedInOneGo) {
  const std::string bad =
      Write("bad.yaml",
            "image: map.pgm\nresolution: -1\nnegate: maybe\noccupied_thresh: nan\n"
            "mode: grey\n");
  const auto map = LoadFloorMap(bad);
  ASSERT_FALSE(map.ok());
  EXPECT_EQ(map.error().code, ErrorCode::kBadConfig);
  EXPECT_THAT(map.error().message,
              AllOf(HasSubstr("bad.yaml:1: origin: missing"), HasSubstr("bad.yaml:2: resolution"),
                    HasSubstr("bad.yaml:3: negate"), HasSubstr("bad.yaml:4: occupied_thresh"),
                    HasSubstr("bad.yaml:5: mode: must be one of trinary, scale, raw")));
}

TEST_F(FloorMapFile, NumbersMustBeFiniteAndInRange) {
  for (const auto& [key, value] :
       std::vector<std::pair<std::string, std::string>>{{"resolution", "nan"},
                                                        {"resolution", ".inf"},
                                                        {"resolution", "0"},
                                                        {"origin", "[0, nan, 0]"},
                                                        {"origin", "[0, 0, .nan]"},
                                                        {"origin", "[0, 0]"},
                                                        {"occupied_thresh", "1.5"},
                                                        {"free_thresh", "-.inf"},
                                                        {"free_thresh", "0.7"},
                                                        {"free_thresh", "abc"}}) {
    const auto map = LoadFloorMap(Yaml(key, value));
    ASSERT_FALSE(map.ok()) << key << " " << value;
    EXPECT_EQ(map.error().code, ErrorCode::kBadConfig);
    EXPECT_THAT(map.error().message, HasSubstr(key + ":")) << value;
  }
  EXPECT_THAT(Letters(Write("map.yaml", "image: [map.pgm\n")), HasSubstr("map.yaml:"));
  EXPECT_THAT(Letters(Write("map.yaml", "- a\n- b\n")), HasSubstr("must be `key: value` lines"));
}

// What gw-grid saves is what gw-navigate drives on.
TEST_F(FloorMapFile, TheFloorMapOfTheGridIsReadBackCellByCell) {
  grid::FloorImage image{0.05, -7, 3, 5, 4, {}};
  for (int i = 0; i < image.width * image.height; ++i) {
    image.cells.push_back(i % 3 == 0   ? CellState::kOccupied
                          : i % 7 == 1 ? CellState::kUnknown
                                       : CellState::kFree);
  }
  ASSERT_TRUE(grid::WriteMapServer(folder_.string(), image).ok());
  const auto map = LoadFloorMap((folder_ / "map.yaml").string());
  ASSERT_TRUE(map.ok()) << map.error().message;
  ASSERT_EQ(map->width, image.width);
  ASSERT_EQ(map->height, image.height);
  EXPECT_EQ(map->resolution, image.cell_m);
  EXPECT_EQ(map->origin, image.cell_m * Eigen::Vector2d(image.first_x, image.first_y));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      EXPECT_EQ(map->Occupied(x, y), image.at(x, y) == CellState::kOccupied) << x << ", " << y;
      EXPECT_EQ(map->Unknown(x, y), image.at(x, y) == CellState::kUnknown) << x << ", " << y;
    }
  }
}

}  // namespace
}  // namespace gw::floorplan

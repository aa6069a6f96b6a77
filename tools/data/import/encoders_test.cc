// Counts of two encoders as wheel increments.
#include "tools/data/import/encoders.h"

#include <gmock/gmock.h>

#include <cmath>

#include "tools/data/import/test_folder.h"

namespace gw::importer {
namespace {

using testing::HasSubstr;

constexpr EncoderBase kBase = {1000, 0.5};

Result<std::vector<WheelSample>> Read(const std::string& text) {
  const TestFolder folder;
  folder.Write("ticks.txt", text);
  std::vector<std::string> warnings;
  return ReadEncoders(folder.path() / "ticks.txt", kBase, warnings);
}

// 1 m ahead, a turn on the spot to the left by 1 rad, a quarter circle of radius 1 m.
TEST(Encoders, CountsBecomeArcs) {
  const double quarter = M_PI / 2;
  std::string text = "# t left right\n1.0 70000 -5\n1.02 71000 995\n1.04 70750 1245\n";
  text += "1.06 " + std::to_string(70750 + 750 * quarter) + " " +
          std::to_string(1245 + 1250 * quarter) + "\n";
  const auto wheels = Read(text);
  ASSERT_TRUE(wheels) << wheels.error().message;
  ASSERT_EQ(wheels->size(), 3u);
  EXPECT_NEAR((*wheels)[0].dx_m, 1, 1e-12);
  EXPECT_NEAR((*wheels)[0].dyaw_rad, 0, 1e-12);
  EXPECT_EQ((*wheels)[0].left_ticks, 71000 % 65536);
  EXPECT_NEAR((*wheels)[1].dx_m, 0, 1e-12);
  EXPECT_NEAR((*wheels)[1].dyaw_rad, 1, 1e-12);
  EXPECT_NEAR((*wheels)[2].dx_m, 1, 1e-6);
  EXPECT_NEAR((*wheels)[2].dy_m, 1, 1e-6);
  EXPECT_NEAR((*wheels)[2].dyaw_rad, quarter, 1e-6);
  EXPECT_EQ((*wheels)[2].utime_begin, (*wheels)[1].utime);
}

TEST(Encoders, BadFilesAreRefused) {
  EXPECT_THAT(Read("1.0 5\n").error().message, HasSubstr("ticks.txt:1: "));
  EXPECT_THAT(Read("1.0 5 5\n").error().message, HasSubstr("a single reading"));
  EXPECT_THAT(Read("1 nan 5\n2 nan 5\n3 1 5\n").error().message, HasSubstr("2 of 3 rows"));
}

}  // namespace
}  // namespace gw::importer

#include "tools/sim/sim/recorded_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace gw::sim {
namespace {

using ::testing::HasSubstr;

class RecordedMotionFile : public ::testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& content) {
    const std::string path =
        (std::filesystem::path(::testing::TempDir()) / ("recorded_motion_" + name)).string();
    std::ofstream(path) << content;
    written_.push_back(path);
    return path;
  }
  void TearDown() override {
    for (const std::string& path : written_) std::filesystem::remove(path);
  }
  // A circle of 2 m radius at 0.5 m/s.
  static std::string Circle(double begin, double end, double step) {
    std::string text = "# t x y z qx qy qz qw\n";
    char line[200];
    for (double t = begin; t <= end; t += step) {
      const double a = t / 4;
      std::snprintf(line, sizeof line, "%.6f %.9f %.9f 0 0 0 %.9f %.9f\n", 1000 + t,
                    2 * std::sin(a), 2 - 2 * std::cos(a), std::sin(a / 2), std::cos(a / 2));
      text += line;
    }
    return text;
  }
  std::vector<std::string> written_;
};

TEST_F(RecordedMotionFile, TheCurveStaysCloseToTheRecordingAndInsideItsCorridor) {
  const auto motion =
      RecordedMotion::Load(Write("gt", Circle(0, 20, 0.025)), Write("odom", Circle(0.5, 19, 0.05)));
  ASSERT_TRUE(motion.ok()) << motion.error().message;
  EXPECT_NEAR(motion->duration_s(), 18.5, 0.1);
  EXPECT_NEAR(motion->odometry_rate_hz(), 20, 0.5);
  const floorplan::FloorMap map = motion->CorridorAround(1.5);
  for (double t = 0; t < motion->duration_s(); t += 0.013) {
    const double a = (t + 0.5) / 4;
    const auto at = motion->At(t);
    EXPECT_LT((at.position - Eigen::Vector2d(2 * std::sin(a), 2 - 2 * std::cos(a))).norm(), 0.003);
    EXPECT_LT(std::abs(std::remainder(at.yaw - a, 2 * 3.141592653589793)), 0.003);
    EXPECT_FALSE(map.Occupied(map.CellOf(at.position).x(), map.CellOf(at.position).y()));
  }
}

TEST_F(RecordedMotionFile, GapsAndNonsenseAreErrorsWithTheirLine) {
  const std::string good = Write("good", Circle(0, 20, 0.05));
  const std::string gap = Write("gap", Circle(0, 5, 0.5) + Circle(8, 9, 0.5));
  EXPECT_THAT(RecordedMotion::Load(gap, good).error().message, HasSubstr("gap:14: gap of"));
  EXPECT_THAT(RecordedMotion::Load(good, Write("bad", "1000 1 2 3\n")).error().message,
              HasSubstr("bad:1: want"));
  EXPECT_THAT(RecordedMotion::Load(good, Write("late", Circle(30, 40, 0.1))).error().message,
              HasSubstr("shares less than a second"));
  EXPECT_EQ(RecordedMotion::Load(good, "none").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace gw::sim

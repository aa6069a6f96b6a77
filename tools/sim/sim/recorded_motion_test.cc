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
    std::string path =
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
  EXPECT_TRUE(motion->TellsRates());
  const floorplan::FloorMap map = motion->CorridorAround(1.5);
  for (double t = 0; t < motion->duration_s(); t += 0.013) {
    const double a = (t + 0.5) / 4;
    const auto at = motion->At(t);
    EXPECT_LT((at.position - Eigen::Vector2d(2 * std::sin(a), 2 - 2 * std::cos(a))).norm(), 0.003);
    EXPECT_LT(std::abs(std::remainder(at.yaw - a, 2 * 3.141592653589793)), 0.003);
    EXPECT_FALSE(map.Occupied(map.CellOf(at.position).x(), map.CellOf(at.position).y()));
  }
}

TEST_F(RecordedMotionFile, TheOdometryCarriesBetweenTheKeptScansOfALaser) {
  // A pose every 3 s, in which the robot turns by 43 degrees.
  const auto motion =
      RecordedMotion::Load(Write("kept", Circle(0, 21, 3)), Write("odom", Circle(0, 21, 0.1)));
  ASSERT_TRUE(motion.ok()) << motion.error().message;
  EXPECT_FALSE(motion->TellsRates());
  for (double t = 1; t < 17; t += 0.013) {
    const auto at = motion->At(t);
    EXPECT_LT((at.position - Eigen::Vector2d(2 * std::sin(t / 4), 2 - 2 * std::cos(t / 4))).norm(),
              0.005);
    EXPECT_LT(std::abs(std::remainder(at.yaw - t / 4, 2 * 3.141592653589793)), 0.003);
  }
}

TEST_F(RecordedMotionFile, AJumpOfTheReferenceIsNoShockForTheRobot) {
  // Straight ahead at 0.5 m/s; the reference says 0.4 m more from 10 s on.
  const auto line = [](double end, double step, double jump_at, double jump) {
    std::string text;
    char row[100];
    for (double t = 0; t <= end; t += step) {
      std::snprintf(row, sizeof row, "%.6f %.6f 0 0 0 0 0 1\n", t,
                    0.5 * t + (t >= jump_at ? jump : 0));
      text += row;
    }
    return text;
  };
  const auto motion = RecordedMotion::Load(Write("jumps", line(20, 0.025, 10, 0.4)),
                                           Write("odom", line(20, 0.05, 30, 0)));
  ASSERT_TRUE(motion.ok()) << motion.error().message;
  double fastest = 0;
  for (double t = 1; t < 19; t += 0.01) {
    fastest = std::max(fastest, (motion->At(t + 0.01).position - motion->At(t).position).norm());
  }
  // m/s; a Gaussian of 0.25 m, which is 0.5 s here, spreads 0.4 m: 0.32 m/s.
  EXPECT_LT(fastest / 0.01, 0.5 + 0.4);
  EXPECT_NEAR(motion->At(15).position.x(), 7.9, 0.001);
}

TEST_F(RecordedMotionFile, ARobotWhoseWheelsStandStands) {
  // 1 m, 20 s of rest in which the reference creeps by 0.1 m, 1 m.
  std::string reference, odometry;
  char row[100];
  for (double t = 0; t <= 24; t += 0.05) {
    const double moved = 0.5 * (std::min(t, 2.0) + std::max(t - 22, 0.0));
    std::snprintf(row, sizeof row, "%.6f %.6f 0 0 0 0 0 1\n", t, moved);
    odometry += row;
    std::snprintf(row, sizeof row, "%.6f %.6f 0 0 0 0 0 1\n", t, moved + 0.1 * t / 24);
    reference += row;
  }
  const auto motion = RecordedMotion::Load(Write("creeps", reference), Write("rests", odometry));
  ASSERT_TRUE(motion.ok()) << motion.error().message;
  EXPECT_LT((motion->At(21.5).position - motion->At(2.5).position).norm(), 1e-5);
  EXPECT_GT((motion->At(24).position - motion->At(0).position).norm(), 2.02);
}

TEST_F(RecordedMotionFile, TheWayIsThatOfTheWheelsWhereverTheReferenceIsMounted) {
  // Wheels on an S of 2 m radius; the reference is 0.2 m behind them, 0.05 m to the left, and looks
  // 3 degrees to the left.
  const double askew = 3 * 3.141592653589793 / 180;
  const auto yaw_at = [](double t) { return 2 * std::sin(t / 4); };
  std::string reference, odometry;
  Eigen::Vector3d pose = Eigen::Vector3d::Zero();
  char row[200];
  for (double t = 0; t <= 40; t += 0.02) {
    // Rolls along its own heading.
    const double yaw = yaw_at(t);
    pose.head<2>() += 0.5 * 0.02 * Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
    pose.z() = yaw_at(t + 0.01);
    const Eigen::Vector2d p =
        pose.head<2>() + Eigen::Rotation2Dd(pose.z()) * Eigen::Vector2d(-0.2, 0.05);
    std::snprintf(row, sizeof row, "%.6f %.9f %.9f 0 0 0 %.9f %.9f\n", t, pose.x(), pose.y(),
                  std::sin(pose.z() / 2), std::cos(pose.z() / 2));
    odometry += row;
    std::snprintf(row, sizeof row, "%.6f %.9f %.9f 0 0 0 %.9f %.9f\n", t, p.x(), p.y(),
                  std::sin((pose.z() + askew) / 2), std::cos((pose.z() + askew) / 2));
    reference += row;
  }
  const auto motion = RecordedMotion::Load(Write("beside", reference), Write("rolls", odometry));
  ASSERT_TRUE(motion.ok()) << motion.error().message;
  // It rolls straight ahead all the time.
  double sideways = 0, way = 0;
  for (double t = 1; t < 39; t += 0.1) {
    const auto a = motion->At(t), b = motion->At(t + 0.1);
    const Eigen::Vector2d step =
        Eigen::Rotation2Dd(-0.5 * (a.yaw + b.yaw)) * (b.position - a.position);
    sideways = std::max(sideways, std::abs(step.y()));
    way += step.x();
  }
  EXPECT_LT(sideways, 0.0005);
  EXPECT_NEAR(way, 19, 0.1);
}

TEST_F(RecordedMotionFile, GapsAndNonsenseAreErrorsWithTheirLine) {
  const std::string good = Write("good", Circle(0, 40, 0.05));
  const std::string gap = Write("gap", Circle(0, 5, 0.5) + Circle(20, 30, 0.5));
  EXPECT_THAT(RecordedMotion::Load(gap, good).error().message, HasSubstr("gap: no pose for 7.4"));
  EXPECT_THAT(RecordedMotion::Load(good, gap).error().message, HasSubstr("gap: gap of 15.0"));
  EXPECT_THAT(RecordedMotion::Load(good, Write("bad", "1000 1 2 3\n")).error().message,
              HasSubstr("bad:1: want"));
  EXPECT_THAT(RecordedMotion::Load(good, Write("late", Circle(50, 60, 0.1))).error().message,
              HasSubstr("shares less than a second"));
  EXPECT_EQ(RecordedMotion::Load(good, "none").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace gw::sim

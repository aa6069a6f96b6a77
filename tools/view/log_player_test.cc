#include "tools/view/log_player.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/data/files/json.h"

namespace gw::view {
namespace {

using tools::Json;

// Drives 0.1 m in every tenth of a second, for 20 s.
std::string WriteLog() {
  const char* folder = std::getenv("TEST_TMPDIR");
  const std::string path = std::string(folder == nullptr ? "." : folder) + "/player.lcm";
  auto writer = process::EventLogWriter::Create(path);
  EXPECT_TRUE(writer.ok());
  for (int i = 0; i <= 200; ++i) {
    FramePose pose;
    pose.utime = Utime{1'000'000 + i * 100'000};
    pose.seq = i + 1;
    pose.status = TrackingStatus::kTracking;
    pose.T_WB = SE3(Eigen::Quaterniond::Identity(), {0.1 * i, 0, 0});
    EXPECT_TRUE(writer->Append(pose.utime, wire::kFramePose, wire::Encode(pose)).ok());
  }
  EXPECT_TRUE(writer->Close().ok());
  return path;
}

size_t WayPoints(LogPlayer& player) {
  size_t points = 0;
  for (const auto& message : player.translator().State(foxglove::Topic::kTrajectory)) {
    const Json update = Json::parse(*message.json);
    for (const Json& entity : update["entities"]) {
      points += entity["lines"][0]["points"].size();
    }
  }
  return points;
}

LogPlayer Open(double speed = 1) {
  auto player = LogPlayer::Open(WriteLog(), {}, speed);
  EXPECT_TRUE(player.ok());
  return std::move(*player);
}

TEST(LogPlayer, PlaysAtItsSpeedAndStopsAtTheEnd) {
  LogPlayer player = Open(2);
  EXPECT_NEAR(player.playback().duration_s, 20, 1e-9);
  player.Advance(Milliseconds(5000));
  EXPECT_NEAR(player.playback().position_s, 10, 1e-9);
  EXPECT_EQ(WayPoints(player), 101u);
  player.Advance(Milliseconds(50'000));
  EXPECT_EQ(WayPoints(player), 202u);  // two pieces share a point
  EXPECT_TRUE(player.playback().paused);
}

TEST(LogPlayer, PausedItStands) {
  LogPlayer player = Open();
  player.Control({.paused = true});
  player.Advance(Milliseconds(5000));
  EXPECT_EQ(player.playback().position_s, 0);
}

TEST(LogPlayer, SeeksForwardAndBackInSteps) {
  LogPlayer player = Open();
  player.Control({.position_s = 15, .paused = true});
  for (int i = 0; i < 100 && player.catching_up(); ++i) player.Advance(Milliseconds(20), 20);
  EXPECT_TRUE(player.TakeJumped());
  EXPECT_FALSE(player.TakeJumped());
  EXPECT_EQ(WayPoints(player), 151u);
  player.Control({.position_s = 5});
  for (int i = 0; i < 100 && player.catching_up(); ++i) player.Advance(Milliseconds(20), 20);
  EXPECT_EQ(WayPoints(player), 51u);
  player.Control({.position_s = -7});
  player.Control({.position_s = 1e9});
  while (player.catching_up()) player.Advance(Milliseconds(20), 20);
  EXPECT_NEAR(player.playback().position_s, 20, 1e-9);
}

TEST(LogPlayer, PlayAfterTheEndBeginsAnew) {
  LogPlayer player = Open();
  player.Advance(Milliseconds(60'000));
  EXPECT_TRUE(player.playback().paused);
  player.Control({.paused = false});
  player.Advance(Milliseconds(20));
  EXPECT_LT(player.playback().position_s, 1);
}

TEST(LogPlayer, NoLogIsAnError) {
  EXPECT_FALSE(LogPlayer::Open("/nonexistent.lcm", {}, 1).ok());
}

}  // namespace
}  // namespace gw::view

#include "common/process/sequence_monitor.h"

#include <gtest/gtest.h>

namespace gw::process {
namespace {

TEST(SequenceMonitor, CountsGaps) {
  SequenceMonitor monitor;
  EXPECT_EQ(monitor.Observe("IMU", "", 100), 0);  // joined late: nothing was lost
  EXPECT_EQ(monitor.Observe("IMU", "", 101), 0);
  EXPECT_EQ(monitor.Observe("IMU", "", 105), 3);
  EXPECT_EQ(monitor.Observe("IMU", "", 106), 0);
  EXPECT_EQ(monitor.Observe("IMU", "", 108), 1);
  EXPECT_EQ(monitor.lost().at("IMU"), 4);
}

TEST(SequenceMonitor, ARestartedSenderIsNotALoss) {
  SequenceMonitor monitor;
  monitor.Observe("DR", "", 5000);
  EXPECT_EQ(monitor.Observe("DR", "", 1), 0);
  EXPECT_EQ(monitor.Observe("DR", "", 2), 0);
  EXPECT_EQ(monitor.Observe("DR", "", 4), 1);
}

TEST(SequenceMonitor, ARepeatIsNotALoss) {
  SequenceMonitor monitor;
  monitor.Observe("DR", "", 7);
  EXPECT_EQ(monitor.Observe("DR", "", 7), 0);
  EXPECT_EQ(monitor.Observe("DR", "", 8), 0);
  EXPECT_TRUE(monitor.lost().empty());
}

TEST(SequenceMonitor, SendersAndChannelsCountApart) {
  SequenceMonitor monitor;
  monitor.Observe("HEALTH", "gw-camera", 10);
  EXPECT_EQ(monitor.Observe("HEALTH", "gw-frontend", 90), 0);
  EXPECT_EQ(monitor.Observe("HEALTH", "gw-camera", 11), 0);
  EXPECT_EQ(monitor.Observe("IMU", "gw-camera", 55), 0);
  EXPECT_EQ(monitor.Observe("HEALTH", "gw-frontend", 92), 1);
}

}  // namespace
}  // namespace gw::process

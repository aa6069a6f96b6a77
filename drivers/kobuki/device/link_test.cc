#include "drivers/kobuki/device/link.h"

#include <gtest/gtest.h>

#include <vector>

namespace gw::kobuki {
namespace {

Utime Ms(int64_t ms) {
  return Utime{1000 * ms};
}

TEST(KobukiLink, RetriesLessAndLessOftenWhileTheDeviceIsAbsent) {
  Link link;
  std::vector<int64_t> tries;
  for (int64_t ms = 0; ms < 60'000; ms += 5) {
    if (!link.ShouldOpen(Ms(ms))) continue;
    tries.push_back(ms);
    link.OpenFailed(Ms(ms));
  }
  ASSERT_GT(tries.size(), 10u);
  EXPECT_EQ(tries[0], 0);
  EXPECT_EQ(tries[1], 250);
  EXPECT_EQ(tries[2], 750);
  EXPECT_EQ(tries.back() - tries[tries.size() - 2], 5000);
  EXPECT_EQ(link.state(Ms(60'000)), LinkState::kAbsent);
}

TEST(KobukiLink, ComesBackSoonAfterUnpluggingOfABaseThatTalked) {
  Link link;
  for (int i = 0; i < 10; ++i) link.OpenFailed(Ms(i));
  link.Opened(Ms(10'000));
  link.Frame(Ms(10'020));
  link.Closed(Ms(10'040));
  EXPECT_FALSE(link.ShouldOpen(Ms(10'100)));
  EXPECT_TRUE(link.ShouldOpen(Ms(10'300)));
}

TEST(KobukiLink, SilentGarbageAndTalkingAreToldApart) {
  Link link;
  link.Opened(Ms(0));
  EXPECT_EQ(link.state(Ms(100)), LinkState::kConnecting);
  EXPECT_EQ(link.state(Ms(600)), LinkState::kSilent);
  link.Bytes(Ms(700));
  EXPECT_EQ(link.state(Ms(800)), LinkState::kGarbage);
  link.Bytes(Ms(900));
  link.Frame(Ms(900));
  EXPECT_EQ(link.state(Ms(1300)), LinkState::kTalking);
  EXPECT_EQ(link.state(Ms(1500)), LinkState::kSilent);
}

TEST(KobukiLink, SilentPortIsReopenedNowAndThen) {
  Link link;
  int reopened = 0;
  for (int64_t ms = 0; ms < 60'000; ms += 5) {
    if (link.ShouldReopen(Ms(ms))) {
      link.Closed(Ms(ms));
      ++reopened;
    }
    if (link.ShouldOpen(Ms(ms))) link.Opened(Ms(ms));
  }
  EXPECT_GE(reopened, 5);
  EXPECT_LE(reopened, 12);
}

}  // namespace
}  // namespace gw::kobuki

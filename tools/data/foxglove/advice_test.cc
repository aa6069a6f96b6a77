#include "tools/data/foxglove/advice.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

namespace gw::foxglove {
namespace {

std::string Runbook() {
  std::ifstream file(std::string(GW_SOURCE_DIR) + "/deploy/runbook.md");
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Advice, IsWhatTheRunbookSays) {
  const std::string runbook = Runbook();
  ASSERT_FALSE(runbook.empty());
  for (const Advice& advice : kAdvice) {
    EXPECT_NE(runbook.find(advice.action), std::string::npos) << advice.action;
  }
  EXPECT_NE(runbook.find(kSilentAction), std::string::npos);
}

TEST(Advice, FitsProcessAndText) {
  Health health;
  health.process = "gw-kobuki";
  health.state = HealthState::kDegraded;
  health.message = "battery low: charge";
  EXPECT_EQ(AdviceFor(health), "charge");
  health.process = "gw-camera";
  EXPECT_EQ(AdviceFor(health), "");
}

TEST(Advice, NamesTheSilentProcess) {
  EXPECT_EQ(AdviceForSilent("gw-x").substr(0, 23), "`systemctl status gw-x`");
}

}  // namespace
}  // namespace gw::foxglove

#include "tools/lab/bench_suite/other_methods.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/config/loader.h"
#include "common/core/format.h"
#include "tools/data/files/text_file.h"
#include "tools/lab/bench_suite/protocol.h"
#include "tools/lab/eval/test_trajectories.h"

namespace gw::bench {
namespace {

std::string Tum(const eval::Trajectory& trajectory) {
  std::string out;
  for (const eval::TimedPose& pose : trajectory) {
    const auto& p = pose.T.translation();
    const auto& q = pose.T.rotation();
    out += FormatFixed(pose.utime.seconds(), 6);
    for (const double v : {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}) {
      out += " " + FormatFixed(v, 9);
    }
    out += "\n";
  }
  return out;
}

class OtherMethods : public testing::Test {
 protected:
  void SetUp() override {
    input_.name = "a";
    input_.config = GW_SOURCE_DIR "/config/robots/turtlebot2_d435i.yaml";
    truth_.T_GB = eval::Eight(400, 1.0 / 30);
    truth_.images = 400;
    T_BC_ = LoadRobotConfig(input_.config)->calibration.camera.T_BC;
    std::filesystem::create_directories(folder_);
  }

  std::vector<CellResult> Score(const OtherMethod& method) {
    auto results = ScoreOther(method, 2, input_, truth_, eval::Alignment::kSe3);
    EXPECT_TRUE(results.ok());
    return *results;
  }

  const std::string folder_ = testing::TempDir() + "gw_other_methods";
  PreparedInput input_;
  InputTruth truth_;
  SE3 T_BC_;
};

TEST_F(OtherMethods, CameraPosesAreMovedToTheBody) {
  eval::Trajectory camera = truth_.T_GB;
  for (auto& pose : camera) pose.T = pose.T * T_BC_;
  ASSERT_TRUE(tools::WriteTextFile(folder_ + "/a.tum", Tum(camera)).ok());
  const auto results = Score({"orb", folder_ + "/{sequence}.tum", false});
  ASSERT_EQ(results.size(), 1u);
  EXPECT_TRUE(results[0].external);
  EXPECT_EQ(results[0].variant, "orb");
  ASSERT_TRUE(results[0].measures.has_value());
  EXPECT_LT(*results[0].measures->ape_live_m, 1e-6);
  EXPECT_EQ(results[0].measures->lost, 0);
  // Taken for poses of the body they are off by the lever arm, which turns.
  EXPECT_GT(*Score({"orb", folder_ + "/{sequence}.tum", true})[0].measures->ape_live_m, 0.01);
}

TEST_F(OtherMethods, WhatIsNotTrackedOrMissingFailsByTheProtocol) {
  eval::Trajectory half(truth_.T_GB.begin(), truth_.T_GB.begin() + 190);
  ASSERT_TRUE(tools::WriteTextFile(folder_ + "/a_0.tum", Tum(half)).ok());
  std::filesystem::remove(folder_ + "/a_1.tum");
  const auto results = Score({"vins", folder_ + "/{sequence}_{run}.tum", true});
  ASSERT_EQ(results.size(), 2u);
  ASSERT_TRUE(results[0].measures.has_value());
  EXPECT_NEAR(results[0].measures->tracked_share(), 190.0 / 400, 0.01);
  EXPECT_TRUE(RunFailed(results[0]));
  EXPECT_THAT(results[1].failure, testing::HasSubstr("a_1.tum"));
  EXPECT_TRUE(RunFailed(results[1]));
}

}  // namespace
}  // namespace gw::bench

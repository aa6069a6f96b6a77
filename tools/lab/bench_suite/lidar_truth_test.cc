#include "tools/lab/bench_suite/lidar_truth.h"

#include <gtest/gtest.h>

#include "tools/lab/eval/evaluate.h"
#include "tools/lab/eval/test_trajectories.h"

namespace gw::bench {
namespace {

TEST(LidarTruth, IsNearTheTruthAndNotTheTruth) {
  const eval::Trajectory truth = eval::Eight(1500, 0.01);
  const LidarTruth lidar{10, 0.02, 0.3};
  const auto smooth = AsOfLidar(truth, lidar, 1);
  ASSERT_TRUE(smooth.ok());
  eval::EvalOptions options;
  options.alignment = eval::Alignment::kNone;
  const auto error = eval::Evaluate(truth, *smooth, options);
  ASSERT_TRUE(error.ok());
  EXPECT_LT(error->ape_translation_m.rmse, 0.5 * 0.0346);  // of 0.02 m in three axes
  EXPECT_GT(error->ape_translation_m.rmse, 0.001);
  EXPECT_EQ(smooth->at(100).T.matrix(), AsOfLidar(truth, lidar, 1)->at(100).T.matrix());
  EXPECT_NE(smooth->at(100).T.matrix(), AsOfLidar(truth, lidar, 2)->at(100).T.matrix());
  EXPECT_FALSE(AsOfLidar(eval::Eight(50, 0.01), lidar, 1).ok());
}

}  // namespace
}  // namespace gw::bench

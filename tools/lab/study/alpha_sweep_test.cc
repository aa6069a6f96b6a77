#include "tools/lab/study/alpha_sweep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gw::study {
namespace {

eval::Trajectory Straight(double scale, const SE3& T_start) {
  eval::Trajectory out;
  for (int i = 0; i <= 100; ++i) {
    out.push_back(
        {{i * 33333}, T_start * SE3(Eigen::Quaterniond::Identity(), {scale * 0.01 * i, 0, 0})});
  }
  return out;
}

TEST(DriftRmse, StartsAtTheFirstPoseWhateverTheFrame) {
  const SE3 T_start(ExpSO3({0.1, -0.2, 1.3}), {4, 5, 6});
  const auto none = DriftRmse(Straight(1, T_start), Straight(1, SE3()));
  ASSERT_TRUE(none.ok());
  EXPECT_NEAR(*none, 0, 1e-9);
  // 10 % too far on 1 m: the error grows evenly to 0.1 m.
  const auto drift = DriftRmse(Straight(1, T_start), Straight(1.1, SE3()));
  ASSERT_TRUE(drift.ok());
  EXPECT_NEAR(*drift, 0.1 / std::sqrt(3.0), 1e-3);
  EXPECT_EQ(DriftRmse({}, Straight(1, SE3())).error().code, ErrorCode::kBadData);
}

TEST(BestOf, TakesTheMedianNotTheLuckiestRun) {
  const std::vector<AlphaResult> results = {{-1, {0.5, 0.01, 0.6}}, {0, {0.3, 0.3, 0.3}}};
  EXPECT_EQ(BestOf(results).log10_alpha, 0);
}

}  // namespace
}  // namespace gw::study

#include "tools/study/quality.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace gw::study {
namespace {

TEST(Quality, BinsHoldTheirCountsAndTheLastIsOpen) {
  const std::vector<QualitySample> samples = {
      {0, 5, 3.0, 0.3}, {99, 5, 4.0, 0.4}, {100, 5, 1.0, 0.1}, {900, 5, 2.0, 0.2}};
  const auto bins = BinBy(samples, &QualitySample::num_detected, 100, 4);
  ASSERT_EQ(bins.size(), 3u);
  EXPECT_EQ(bins[0].low, 0);
  EXPECT_EQ(bins[0].high, 100);
  EXPECT_EQ(bins[0].images, 2);
  EXPECT_NEAR(bins[0].ape_rmse_m, std::sqrt(12.5), 1e-12);
  EXPECT_NEAR(bins[0].motion_rmse_m, std::sqrt(0.125), 1e-12);
  EXPECT_EQ(bins[1].low, 100);
  EXPECT_EQ(bins[2].low, 300);
  EXPECT_EQ(bins[2].images, 1);
  EXPECT_NEAR(bins[2].ape_rmse_m, 2.0, 1e-12);
}

// A circle, on which the estimate loses the scale of its motion in the second half.
TEST(Quality, AnErrorOfTheMotionIsForgottenAfterASecond) {
  constexpr int kImages = 300;
  eval::Trajectory truth;
  measure::SlamRun run;
  SE3 T_WB;
  for (int i = 0; i < kImages; ++i) {
    const double t = i / 30.0;
    truth.push_back(
        {UtimeFromSeconds(t),
         SE3(ExpSO3({0, 0, 0.6 * t}), {2 * std::sin(0.6 * t), 2 - 2 * std::cos(0.6 * t), 0})});
    if (i > 0) {
      SE3 motion = truth[i - 1].T.inverse() * truth[i].T;
      const bool bad = i >= 100 && i < 130;
      if (bad) motion = SE3(motion.rotation(), 1.5 * motion.translation());
      T_WB = T_WB * motion;
    }
    FramePose f;
    f.utime = truth[i].utime;
    f.T_WB = T_WB;
    f.num_detected = i;
    run.frames.push_back(f);
  }
  const auto samples = QualitySamples(run, truth);
  ASSERT_TRUE(samples.ok()) << samples.error().message;
  // The partner one second before may be a tenth of a second late: 3 images more than 270.
  ASSERT_EQ(samples->size(), kImages - 27u);
  for (const QualitySample& s : *samples) {
    const bool healthy = s.num_detected < 100 || s.num_detected >= 159;
    EXPECT_EQ(s.motion_m < 1e-6, healthy) << s.num_detected;
  }
  // Half as far again as it should be, over the second that has just ended.
  const auto at = [&](int image) { return (*samples)[image - 27]; };
  ASSERT_EQ(at(129).num_detected, 129);
  EXPECT_NEAR(at(129).motion_m, 0.6, 0.02);
  EXPECT_GT(at(250).ape_m, 0.05);
}

}  // namespace
}  // namespace gw::study

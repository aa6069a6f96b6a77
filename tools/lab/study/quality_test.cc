#include "tools/lab/study/quality.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace gw::study {
namespace {

TEST(Quality, BinsHoldTheirCountsAndTheLastIsOpen) {
  const std::vector<QualitySample> samples = {{0, 5, true, 0.3},
                                              {99, 5, true, 0.4},
                                              {50, 5, false, 9.0},
                                              {100, 5, false, 0.1},
                                              {900, 5, true, 0.2}};
  const auto bins = BinBy(samples, &QualitySample::num_detected, 100, 4);
  ASSERT_EQ(bins.size(), 3u);
  EXPECT_EQ(bins[0].low, 0);
  EXPECT_EQ(bins[0].high, 100);
  EXPECT_EQ(bins[0].seconds, 3);
  EXPECT_EQ(bins[0].seen, 2);
  EXPECT_NEAR(bins[0].motion_rmse_m, std::sqrt(0.125), 1e-12);
  EXPECT_EQ(bins[1].low, 100);
  EXPECT_EQ(bins[1].seen, 0);
  EXPECT_EQ(bins[2].low, 300);
  EXPECT_EQ(bins[2].seconds, 1);
  EXPECT_NEAR(bins[2].motion_rmse_m, 0.2, 1e-12);
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
    f.num_detected = i < 200 ? 500 : i;
    f.num_tracked = i == 220 ? 10 : 100;
    f.status = i == 240 ? TrackingStatus::kDrOnly : TrackingStatus::kTracking;
    run.frames.push_back(f);
  }
  const auto samples = QualitySamples(run, truth);
  ASSERT_TRUE(samples.ok()) << samples.error().message;
  // The partner one second before may be a tenth of a second late: 3 images more than 270.
  ASSERT_EQ(samples->size(), kImages - 27u);
  const auto at = [&](int image) { return (*samples)[image - 27]; };
  for (int image = 27; image < kImages; ++image) {
    const bool healthy = image < 100 || image >= 159;
    EXPECT_EQ(at(image).motion_m < 1e-6, healthy) << image;
    // Lowest counts of the second.
    EXPECT_EQ(at(image).num_tracked == 10, image >= 220 && image <= 250) << image;
    EXPECT_EQ(at(image).seen, image < 240 || image > 270) << image;
  }
  EXPECT_EQ(at(215).num_detected, 200);
  // Half as far again as it should be, over the second that has just ended.
  EXPECT_NEAR(at(129).motion_m, 0.6, 0.02);
}

}  // namespace
}  // namespace gw::study

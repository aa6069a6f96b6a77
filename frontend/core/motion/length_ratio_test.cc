#include "frontend/core/motion/length_ratio.h"

#include <gtest/gtest.h>

namespace gw::frontend {
namespace {

constexpr double kNoise = 1e-4;  // m^2, a centimetre

TEST(LengthRatio, FindsTheFactorFromAWindowOn) {
  LengthRatio ratio;
  EXPECT_FALSE(ratio.Fault());
  ratio.Add({{0.1, 0}, {0.12, 0}, kNoise, 0});
  EXPECT_FALSE(ratio.Fault()) << "a way of 10 cm tells nothing";
  ratio.Add({{0.4, 0}, {0.48, 0}, kNoise, 0});
  ASSERT_TRUE(ratio.Fault());
  EXPECT_NEAR(*ratio.Fault(), 1.2, 1e-9);
}

TEST(LengthRatio, WheelsThatAreLateAreNoFaultOfLengths) {
  LengthRatio ratio;
  // From rest to 0.5 m/s, told 50 ms late.
  ratio.Add({{0.375, 0}, {0.4, 0}, kNoise, 0.5});
  EXPECT_EQ(ratio.value(), 1);
  ratio.Add({{0.5, 0}, {0.6, 0}, kNoise, 0.02});
  EXPECT_NEAR(*ratio.Fault(), 1.2, 1e-9);
}

TEST(LengthRatio, AnotherDirectionIsNoneOfLengths) {
  LengthRatio ratio;
  ratio.Add({{0.5, 0}, {0.5, 0.3}, kNoise, 0});
  EXPECT_FALSE(ratio.Fault());
  LengthRatio backwards;
  backwards.Add({{0.5, 0}, {-0.5, 0}, kNoise, 0});
  EXPECT_FALSE(backwards.Fault());
  LengthRatio right;
  right.Add({{0.5, 0}, {0.51, 0.01}, kNoise, 0});
  EXPECT_FALSE(right.Fault()) << "calibration sees to a few per cent";
}

// A baseline is wrong in all windows; wheels may change on the way.
TEST(LengthRatio, AFactorThatNotAllWindowsTellIsNoneOfLengths) {
  for (const double factor : {2.0, 0.5, 1.2, 0.8, -1.0}) {
    LengthRatio ratio;
    for (int i = 0; i < 7; ++i) ratio.Add({{0.5, 0}, {0.5, 0}, kNoise, 0});
    for (int i = 0; i < 30; ++i) {
      ratio.Add({{factor * 0.5, 0}, {0.5, 0}, kNoise, 0});
      EXPECT_FALSE(ratio.Fault()) << factor << " " << i;
    }
  }
}

// ... and with them, what has been corrected is not to be made better.
TEST(LengthRatio, WheelsThatChangeAfterACorrectionAreNoReasonForAnother) {
  LengthRatio ratio;
  ratio.Add({{0.5, 0}, {0.6, 0}, kNoise, 0});
  ratio.Corrected(*ratio.Fault());
  for (int i = 0; i < 30; ++i) {
    ratio.Add({{1, 0}, {0.5, 0}, kNoise, 0});
    EXPECT_FALSE(ratio.IsBetterNow());
  }
}

TEST(LengthRatio, IsWorthACorrectionAgainAfterFourTimesTheWay) {
  LengthRatio ratio;
  ratio.Add({{0.4, 0}, {0.5, 0}, kNoise, 0});  // truly 0.48
  const double coarse = *ratio.Fault();
  ratio.Corrected(coarse);
  EXPECT_NEAR(ratio.value(), 1, 1e-9);
  int windows = 1;
  for (; !ratio.IsBetterNow(); ++windows) ratio.Add({{0.4, 0}, {0.48 / coarse, 0}, kNoise, 0});
  EXPECT_EQ(windows, 4);
  EXPECT_NEAR(coarse * ratio.value(), 1.2 + 0.05 / 4, 1e-9);
  ratio.Corrected(ratio.value());
  EXPECT_FALSE(ratio.IsBetterNow());
}

}  // namespace
}  // namespace gw::frontend

#include "frontend/core/dr_calibration.h"

#include <gtest/gtest.h>

#include <random>

namespace gw::frontend {
namespace {

constexpr DurationUs kFrame{33'333};

SE3 Motion(double x, double heading) {
  Vector6d twist = Vector6d::Zero();
  twist[0] = x;
  twist[5] = heading;
  return SE3::Exp(twist);
}

// A minute of driving in curves to both sides at 0.5 m/s.
class Drive {
 public:
  Drive(double heading_scale, double way_scale)
      : heading_scale_(heading_scale), way_scale_(way_scale) {}

  void Run(DrCalibration* calibration, int images = 1800) {
    std::normal_distribution<double> way_noise(0, 0.001), heading_noise(0, 0.0003);
    for (int i = 0; i < images; ++i) {
      const double heading = 0.02 * std::sin(0.01 * i);
      const SE3 dr =
          Motion(0.5 / 30 + way_noise(random_) / 5, heading + heading_noise(random_) / 5);
      const SE3 vision = Motion(way_scale_ * 0.5 / 30 + way_noise(random_),
                                heading_scale_ * heading + heading_noise(random_));
      calibration->Observe(dr, vision, kFrame);
    }
  }

 private:
  double heading_scale_, way_scale_;
  std::mt19937 random_{1};
};

TEST(DrCalibration, LeavesMotionsAloneAtFirst) {
  const SE3 T = Motion(0.3, 0.4);
  EXPECT_LT((DrCalibration().Corrected(T).inverse() * T).Log().norm(), 1e-12);
}

TEST(DrCalibration, FindsTheScales) {
  DrCalibration calibration;
  Drive(1.008, 0.985).Run(&calibration);
  EXPECT_NEAR(calibration.heading_scale(), 1.008, 0.001);
  EXPECT_NEAR(calibration.way_scale(), 0.985, 0.003);
  const Vector6d twist = calibration.Corrected(Motion(1.0, 1.0)).Log();
  EXPECT_NEAR(twist[0], calibration.way_scale(), 1e-9);
  EXPECT_NEAR(twist[5], calibration.heading_scale(), 1e-9);
  EXPECT_LT(twist.segment<4>(1).norm(), 1e-9) << "other axes stay";
}

TEST(DrCalibration, WithoutATurnTheHeadingScaleStaysUnknown) {
  DrCalibration calibration;
  for (int i = 0; i < 900; ++i) calibration.Observe(Motion(0.02, 0), Motion(0.0201, 1e-5), kFrame);
  EXPECT_NEAR(calibration.heading_scale(), 1, 1e-6);
  EXPECT_NEAR(calibration.way_scale(), 1.005, 0.001);
}

// A slip that the wheels' gate has not seen, a false fit of vision: one window is far off.
TEST(DrCalibration, AWindowThatIsFarOffIsNotUsed) {
  DrCalibration calibration;
  Drive(1, 1).Run(&calibration, 900);
  const double before = calibration.way_scale();
  for (int i = 0; i < 31; ++i) calibration.Observe(Motion(0.017, 0), Motion(0.008, 0), kFrame);
  EXPECT_EQ(calibration.way_scale(), before);
}

TEST(DrCalibration, AnInterruptedWindowIsNotUsed) {
  DrCalibration calibration;
  for (int i = 0; i < 900; ++i) {
    calibration.Observe(Motion(0.02, 0.01), Motion(0.0204, 0.0102), kFrame);
    if (i % 20 == 19) calibration.Interrupt();
  }
  EXPECT_EQ(calibration.way_scale(), 1);
  EXPECT_EQ(calibration.heading_scale(), 1);
}

}  // namespace
}  // namespace gw::frontend

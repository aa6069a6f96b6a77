#include "frontend/core/motion/dr_calibration.h"

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

// A source of DR that says nothing of its scales.
DrState Untold() {
  return {};
}

// The IMU lies on its side, as one in a camera does: its -y is the body's vertical.
DrCalibration Beginner() {
  return DrCalibration(-Eigen::Vector3d::UnitY());
}

double WayScale(const DrCalibration& calibration, const DrState& dr) {
  return calibration.Corrected(Motion(1, 0), kFrame, dr).Log()[0];
}

double HeadingScale(const DrCalibration& calibration, const DrState& dr) {
  return calibration.Corrected(Motion(0, 1), kFrame, dr).Log()[5];
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
      calibration->Observe(dr, vision, kFrame, Untold(), 0);
    }
  }

 private:
  double heading_scale_, way_scale_;
  std::mt19937 random_{1};
};

TEST(DrCalibration, LeavesMotionsAloneAtFirst) {
  const SE3 T = Motion(0.3, 0.4);
  EXPECT_LT((Beginner().Corrected(T, kFrame, Untold()).inverse() * T).Log().norm(), 1e-12);
}

TEST(DrCalibration, FindsTheScales) {
  DrCalibration calibration = Beginner();
  Drive(1.008, 0.985).Run(&calibration);
  EXPECT_NEAR(HeadingScale(calibration, Untold()), 1.008, 0.001);
  EXPECT_NEAR(WayScale(calibration, Untold()), 0.985, 0.003);
  const Vector6d twist = calibration.Corrected(Motion(1.0, 1.0), kFrame, Untold()).Log();
  EXPECT_NEAR(twist[0], WayScale(calibration, Untold()), 1e-9);
  EXPECT_NEAR(twist[5], HeadingScale(calibration, Untold()), 1e-9);
  EXPECT_LT(twist.segment<2>(1).norm(), 2e-3) << "drives where it is said to";
  EXPECT_LT(twist.segment<2>(3).norm(), 1e-9) << "other axes stay";
}

// Dead reckoning without noise turns by rounding alone on a straight way: that tells nothing of the
// scale of the heading, neither there nor at the first turn.
TEST(DrCalibration, AHeadingWithoutNoiseTellsNothingOnAStraightWay) {
  for (const double rounding : {0.0, 1e-300, 1e-30, 1e-15, 1e-9}) {
    DrCalibration calibration = Beginner();
    std::mt19937 random(1);
    std::normal_distribution<double> heading_noise(0, 0.0003);
    for (int i = 0; i < 600; ++i) {
      calibration.Observe(Motion(0.5 / 30, i % 2 == 0 ? rounding : -rounding),
                          Motion(0.5 / 30, heading_noise(random)), kFrame, Untold(), 0);
    }
    EXPECT_NEAR(HeadingScale(calibration, Untold()), 1, 1e-6) << rounding;
    for (int i = 0; i < 90; ++i) {
      calibration.Observe(Motion(0, 0.02), Motion(0, 0.02 + heading_noise(random)), kFrame,
                          Untold(), 0);
    }
    EXPECT_NEAR(HeadingScale(calibration, Untold()), 1, 0.005) << rounding;
  }
}

// Wheels without a gyro: nobody knows their track, and their noise turns them on a straight way.
TEST(DrCalibration, NoiseOfTheWheelsIsNoTurnThatVisionDoesNotSee) {
  constexpr double kNoise = 0.003;  // rad per image
  for (const double track : {1.0, 0.6, 1.7}) {
    DrCalibration calibration = Beginner();
    DrState dr;
    dr.turn_scale_sigma = 1;
    std::mt19937 random(1);
    std::normal_distribution<double> wheels(0, kNoise), vision(0, 0.0003);
    const auto drive = [&](int images, double turn) {
      for (int i = 0; i < images; ++i) {
        calibration.Observe(Motion(0.5 / 30, turn / track + wheels(random)),
                            Motion(0.5 / 30, turn + vision(random)), kFrame, dr, kNoise * kNoise);
      }
    };
    drive(1800, 0);
    EXPECT_NEAR(HeadingScale(calibration, dr), 1, 0.1) << track;
    drive(600, 0.02);
    drive(1800, 0);
    EXPECT_NEAR(HeadingScale(calibration, dr), track, 0.05 * track) << track;
  }
}

// The filter finds the scale by itself, from wheels against gyro: what vision has seen before must
// not be applied a second time.
TEST(DrCalibration, TheFilterMayLearnTheSameScale) {
  DrCalibration calibration = Beginner();
  Drive(1.008, 0.985).Run(&calibration);
  DrState dr;
  dr.turn_scale = 1.006;
  dr.turn_scale_sigma = 0.004;
  dr.wheel_scale = 0.99;
  dr.way_scale_sigma = 0.004;
  EXPECT_NEAR(HeadingScale(calibration, dr), 1.008 / 1.006, 0.001);
  EXPECT_NEAR(WayScale(calibration, dr), 0.985 / 0.99, 0.003);
  dr.turn_scale_sigma = 1e-6;
  EXPECT_NEAR(HeadingScale(calibration, dr), 1, 1e-5) << "the filter is surer";
}

// What a filter with a gyro says that takes `bias` for its bias and does not know it well.
DrState WithGyro(double bias, double sigma) {
  DrState dr;
  dr.imu_alive = true;
  dr.turn_scale_sigma = 0.008;
  dr.gyro_bias_rad_s = {0.1, -bias, 0.2};  // in the axes of the IMU
  dr.cov_twist_coherent(5, 5) = sigma * sigma;
  return dr;
}

// A robot that drives without ever standing: what the filter takes for the bias wanders meanwhile.
TEST(DrCalibration, FindsTheBiasWhateverTheFilterTakesForIt) {
  constexpr double kBias = -0.0015, kSigma = 0.008;  // rad/s
  const double dt = kFrame.seconds();
  DrCalibration calibration = Beginner();
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.0003);
  for (int i = 0; i < 1800; ++i) {
    const double taken = 0.004 * std::sin(0.003 * i), turn = 0.02 * std::sin(0.01 * i);
    calibration.Observe(Motion(0.5 / 30, turn + (kBias - taken) * dt),
                        Motion(0.5 / 30, turn + noise(random)), kFrame, WithGyro(taken, kSigma), 0);
  }
  for (const double taken : {-0.005, 0.0, 0.005}) {
    const SE3 dr = Motion(0, (kBias - taken) * dt);
    const double left = calibration.Corrected(dr, kFrame, WithGyro(taken, kSigma)).Log()[5];
    EXPECT_NEAR(left / dt, 0, 3e-4) << taken;
  }
  DrNoise noise_left;
  noise_left.coherent(5, 5) = kSigma * kSigma;
  calibration.Limit(&noise_left, WithGyro(0, kSigma));
  EXPECT_LT(std::sqrt(noise_left.coherent(5, 5)), 5e-4);
  // A filter that knows its bias, as after a stop, is not corrected.
  const double sure = calibration.Corrected(Motion(0, 0), kFrame, WithGyro(0.005, 1e-5)).Log()[5];
  EXPECT_NEAR(sure / dt, 0, 1e-5);
}

TEST(DrCalibration, WhileTheRobotStandsNothingIsLearntOfTheBias) {
  DrState dr = WithGyro(0.005, 0.008);
  dr.stationary = true;
  DrCalibration calibration = Beginner();
  for (int i = 0; i < 300; ++i) calibration.Observe(SE3(), SE3(), kFrame, dr, 0);
  const DrState other = WithGyro(-0.005, 0.008);
  EXPECT_NEAR(calibration.Corrected(Motion(0, 0), kFrame, other).Log()[5], 0, 1e-9);
}

TEST(DrCalibration, LowersTheDoubtInScalesByWhatItHasLearntAndNothingElse) {
  DrState dr;
  dr.way_scale_sigma = 0.01;
  dr.turn_scale_sigma = 0.05;
  DrNoise noise;
  noise.white.setConstant(0.1);
  noise.coherent.setConstant(0.2);
  noise.coherent(kWayScale, kWayScale) = noise.coherent(kTurnScale, kTurnScale) = 1;
  DrCalibration calibration = Beginner();
  DrNoise left = noise;
  calibration.Limit(&left, dr);
  EXPECT_EQ(left.coherent, noise.coherent) << "knows nothing yet";

  Drive(1.008, 0.985).Run(&calibration);
  calibration.Limit(&left, dr);
  EXPECT_LT(dr.way_scale_sigma * std::sqrt(left.coherent(kWayScale, kWayScale)), 0.003);
  EXPECT_LT(dr.turn_scale_sigma * std::sqrt(left.coherent(kTurnScale, kTurnScale)), 0.002);
  left.coherent(kWayScale, kWayScale) = left.coherent(kTurnScale, kTurnScale) = 1;
  EXPECT_TRUE(left.coherent.isApprox(noise.coherent, 1e-5));
  EXPECT_EQ(left.white, noise.white);
}

TEST(DrCalibration, WithoutATurnTheHeadingScaleStaysUnknown) {
  DrCalibration calibration = Beginner();
  for (int i = 0; i < 900; ++i) {
    calibration.Observe(Motion(0.02, 0), Motion(0.0201, 1e-5), kFrame, Untold(), 0);
  }
  EXPECT_NEAR(HeadingScale(calibration, Untold()), 1, 1e-6);
  EXPECT_NEAR(WayScale(calibration, Untold()), 1.005, 0.001);
}

// A slip that the wheels' gate has not seen, a false fit of vision: one window is far off.
TEST(DrCalibration, AWindowThatIsFarOffIsNotUsed) {
  DrCalibration calibration = Beginner();
  Drive(1, 1).Run(&calibration, 900);
  const double before = WayScale(calibration, Untold());
  for (int i = 0; i < 31; ++i) {
    calibration.Observe(Motion(0.017, 0), Motion(0.008, 0), kFrame, Untold(), 0);
  }
  EXPECT_NEAR(WayScale(calibration, Untold()), before, 1e-6);  // but for what time forgets
}

TEST(DrCalibration, AnInterruptedWindowIsNotUsed) {
  DrCalibration calibration = Beginner();
  for (int i = 0; i < 900; ++i) {
    calibration.Observe(Motion(0.02, 0.01), Motion(0.0204, 0.0102), kFrame, Untold(), 0);
    if (i % 20 == 19) calibration.Interrupt();
  }
  EXPECT_EQ(WayScale(calibration, Untold()), 1);
  EXPECT_EQ(HeadingScale(calibration, Untold()), 1);
}

// The camera looks beside the way it is said to look by this rotation: vision sees the base drive
// that much beside body x.
SE3 SeenBy(const Eigen::Quaterniond& mounting, const SE3& T_BaBb) {
  const SE3 turned(mounting, Eigen::Vector3d::Zero());
  return turned * T_BaBb * turned.inverse();
}

Eigen::Vector3d Straight(const DrCalibration& calibration) {
  return calibration.Corrected(Motion(1, 0), kFrame, Untold()).translation();
}

TEST(DrCalibration, FindsWhereTheBaseDrives) {
  const Eigen::Quaterniond mounting = ExpSO3({0, 0, 0.03}) * ExpSO3({0, -0.01, 0});
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.0005);
  DrCalibration calibration = Beginner();
  for (int i = 0; i < 1800; ++i) {
    const SE3 dr = Motion(0.5 / 30, 0.01 * std::sin(0.01 * i));
    Vector6d beside = Vector6d::Zero();
    beside.segment<2>(1) << noise(random), noise(random);
    calibration.Observe(dr, SeenBy(mounting, dr) * SE3::Exp(beside), kFrame, Untold(), 0);
  }
  const Eigen::Vector3d truth = mounting * Eigen::Vector3d::UnitX();
  EXPECT_NEAR(Straight(calibration).y(), truth.y(), 0.003);
  EXPECT_NEAR(Straight(calibration).z(), truth.z(), 0.003);
  const SE3 turn = calibration.Corrected(Motion(0, 1), kFrame, Untold());
  EXPECT_EQ(turn.translation().norm(), 0) << "a turn on the spot has no direction";
}

// On the spot and in tight curves, a wrong scale of the way looks like a wrong direction.
TEST(DrCalibration, TurnsTeachNoDirection) {
  DrCalibration calibration = Beginner();
  for (int i = 0; i < 1800; ++i) {
    calibration.Observe(Motion(0.01, 0.05), Motion(0.0105, 0.05), kFrame, Untold(), 0);
  }
  EXPECT_LT(Straight(calibration).tail<2>().norm(), 1e-12);
}

TEST(DrCalibration, ADirectionThatIsFarOffIsNotUsed) {
  DrCalibration calibration = Beginner();
  for (int i = 0; i < 60; ++i) {
    const SE3 slid(Eigen::Quaterniond::Identity(), {0.017, 0.01, 0});
    calibration.Observe(Motion(0.017, 0), slid, kFrame, Untold(), 0);
  }
  EXPECT_EQ(Straight(calibration).y(), 0);
}

}  // namespace
}  // namespace gw::frontend

#include "tools/data/fault/sample_faults.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gw::fault {
namespace {

constexpr int64_t kBegin = 5'000'000;
constexpr double kSpeed = 1, kRate = 0.5;  // m/s, rad/s
constexpr DurationUs kPeriod = Milliseconds(20);

// A quarter of a circle and more: wheels at 50 Hz for 4 s, with ticks and heading.
std::vector<WheelSample> Drive() {
  std::vector<WheelSample> out;
  const double dt = kPeriod.seconds();
  for (int i = 1; i <= 200; ++i) {
    WheelSample s;
    s.utime_begin = {kBegin + (i - 1) * kPeriod.us};
    s.utime = s.utime_begin + kPeriod;
    s.seq = i;
    const double turn = kRate * dt;
    s.dx_m = kSpeed / kRate * std::sin(turn);
    s.dy_m = kSpeed / kRate * (1 - std::cos(turn));
    s.dyaw_rad = turn;
    s.has_ticks = s.has_heading = true;
    s.left_ticks = s.right_ticks = static_cast<uint16_t>(65000 + 200 * i);  // wraps
    s.heading_rad = std::remainder(3 + turn * i, 2 * M_PI);
    out.push_back(s);
  }
  return out;
}

std::vector<WheelSample> With(FaultId id, const std::vector<WheelSample>& in, size_t begin = 0) {
  const SampleFault<WheelSample> fault = MakeWheelFault(id);
  std::vector<WheelSample> out;
  for (size_t i = 0; i < in.size(); ++i) {
    std::vector<Edited<WheelSample>> samples = {{in[i], {}}};
    fault(i >= begin, samples);
    for (const auto& edited : samples) out.push_back(edited.sample);
  }
  return out;
}

SE3 Increment(const WheelSample& s) {
  return SE3(ExpSO3({0, 0, s.dyaw_rad}), {s.dx_m, s.dy_m, 0});
}
SE3 Sum(const std::vector<WheelSample>& wheels) {
  SE3 T;
  for (const WheelSample& s : wheels) T = T * Increment(s);
  return T;
}
double Apart(const SE3& a, const SE3& b) {
  return (a.inverse() * b).Log().norm();
}
SE3 Turn(double rad) {
  return SE3(ExpSO3({0, 0, rad}), Eigen::Vector3d::Zero());
}
int Ticks(const std::vector<WheelSample>& wheels) {
  int sum = 0;
  for (size_t i = 1; i < wheels.size(); ++i) {
    sum += static_cast<int16_t>(wheels[i].left_ticks - wheels[i - 1].left_ticks);
  }
  return sum;
}

// The frame of the wheels is turned against the body: what they sum is the body's motion in theirs.
TEST(WheelFault, TurnedGivesTheMotionOfATurnedFrame) {
  const auto in = Drive();
  const SE3 expected = Turn(-M_PI / 2) * Sum(in) * Turn(M_PI / 2);
  EXPECT_LT(Apart(Sum(With(FaultId::kWheelsTurned, in)), expected), 1e-9);
}

// Counting backwards is the same curve driven backwards: the mirror image across y.
TEST(WheelFault, ReversedDrivesTheMirroredCurveAndCountsBackwards) {
  const auto in = Drive();
  const auto out = With(FaultId::kWheelsReversed, in);
  const SE3 sum = Sum(in), reversed = Sum(out);
  EXPECT_NEAR(reversed.translation().x(), -sum.translation().x(), 1e-9);
  EXPECT_NEAR(reversed.translation().y(), sum.translation().y(), 1e-9);
  EXPECT_NEAR(LogSO3(reversed.rotation()).z(), -LogSO3(sum.rotation()).z(), 1e-9);
  EXPECT_EQ(Ticks(out), -Ticks(in));
}

TEST(WheelFault, FactorsScaleWayTurnAndTicks) {
  const auto in = Drive();
  const std::pair<FaultId, double> factors[] = {
      {FaultId::kWheelsDouble, 2}, {FaultId::kWheelsHalf, 0.5}, {FaultId::kWheelsStuck, 0}};
  for (const auto& [id, factor] : factors) {
    const auto out = With(id, in);
    double way = 0, turn = 0;
    for (const WheelSample& s : out) {
      way += std::hypot(s.dx_m, s.dy_m);
      turn += s.dyaw_rad;
    }
    EXPECT_NEAR(way, 4 * factor, 1e-3);
    EXPECT_NEAR(turn, 2 * factor, 1e-9);
    EXPECT_NEAR(Ticks(out), factor * Ticks(in), 1);
  }
}

TEST(WheelFault, MillimetresLeaveTheTurn) {
  const auto in = Drive();
  const auto out = With(FaultId::kWheelsMillimetres, in);
  EXPECT_DOUBLE_EQ(out[7].dx_m, 1000 * in[7].dx_m);
  EXPECT_DOUBLE_EQ(out[7].dy_m, 1000 * in[7].dy_m);
  EXPECT_EQ(out[7].dyaw_rad, in[7].dyaw_rad);
}

TEST(WheelFault, LateMovesStampsAndReception) {
  const auto in = Drive();
  const SampleFault<WheelSample> fault = MakeWheelFault(FaultId::kWheelsLate150);
  std::vector<Edited<WheelSample>> samples = {{in[3], {}}};
  fault(true, samples);
  EXPECT_EQ(samples[0].sample.utime - in[3].utime, Milliseconds(150));
  EXPECT_EQ(samples[0].sample.utime_begin - in[3].utime_begin, Milliseconds(150));
  EXPECT_EQ(samples[0].delay, Milliseconds(150));
}

TEST(WheelFault, ResampledSumsFortyAndSixtyMillisecondsAndLosesNoWay) {
  const auto in = Drive();
  const auto out = With(FaultId::kWheelsResampled, in);
  ASSERT_EQ(out.size(), 79u);  // the first sample begins the sums: 3.98 s
  for (size_t i = 0; i < out.size(); ++i) {
    EXPECT_EQ((out[i].utime - out[i].utime_begin).us, 50'000);
    EXPECT_EQ(out[i].utime.us, in[0].utime.us + static_cast<int64_t>(i + 1) * 50'000);
    EXPECT_EQ(out[i].seq, in[0].seq + static_cast<int64_t>(i));
    EXPECT_NEAR(out[i].dyaw_rad, kRate * (i % 2 == 0 ? 0.04 : 0.06), 1e-9);
  }
  // 79 sums end 10 ms early.
  EXPECT_NEAR(LogSO3(Sum(out).rotation()).z(), kRate * (79 * 0.05 - 0.01), 1e-9);
  EXPECT_NEAR(out.back().heading_rad,
              std::remainder(3 + kRate * (0.02 + 79 * 0.05 - 0.01), 2 * M_PI), 1e-9);
  EXPECT_NEAR(Ticks(out), 10000 * 78 * 0.05, 1e-9 + 201);
}

// A driver at 20 Hz that is fed at 20 Hz: intervals of the input are cut where the sums end.
TEST(WheelFault, ResamplingInterpolatesASlowBase) {
  std::vector<WheelSample> slow;
  for (int i = 1; i <= 40; ++i) {
    WheelSample s;
    s.utime_begin = {kBegin + (i - 1) * 50'000};
    s.utime = s.utime_begin + Milliseconds(50);
    s.dx_m = 0.05;
    slow.push_back(s);
  }
  const auto out = With(FaultId::kWheelsResampled, slow);
  ASSERT_EQ(out.size(), 39u);
  EXPECT_NEAR(out[0].dx_m, 0.04, 1e-12);
  EXPECT_NEAR(out[1].dx_m, 0.06, 1e-12);
  EXPECT_NEAR(Sum(out).translation().x(), 39 * 0.05 - 0.01, 1e-9);
}

TEST(WheelFault, AloneTellsTheSameWayFiveTimesASecond) {
  const auto in = Drive();
  const auto out = With(FaultId::kWheelsAlone, in);
  ASSERT_EQ(out.size(), 19u);
  for (const WheelSample& s : out) {
    EXPECT_EQ((s.utime - s.utime_begin).us, 200'000);
    EXPECT_NEAR(s.dyaw_rad, kRate * 0.2, 1e-9);
  }
  std::vector<Edited<ImuSample>> imu(3);
  MakeImuFault(FaultId::kWheelsAlone)(true, imu);
  EXPECT_TRUE(imu.empty());
}

TEST(WheelFault, StuckHeadingHoldsTheBasesHeadingOrTheWheelsTurn) {
  auto in = Drive();
  const auto held = With(FaultId::kHeadingStuck, in, 50);
  EXPECT_EQ(held[49].heading_rad, in[49].heading_rad);
  EXPECT_EQ(held.back().heading_rad, in[50].heading_rad);
  EXPECT_EQ(held.back().dyaw_rad, in.back().dyaw_rad);
  for (WheelSample& s : in) s.has_heading = false;
  const SE3 straight = Sum(With(FaultId::kHeadingStuck, in));
  EXPECT_NEAR(straight.translation().x(), 4, 1e-3);
  EXPECT_NEAR(straight.translation().y(), 0, 1e-12);
}

TEST(WheelFault, JumpIsOneIncrementOfFiveMetres) {
  const auto in = Drive();
  const auto out = With(FaultId::kWheelsJump, in, 100);
  for (size_t i = 0; i < in.size(); ++i) {
    EXPECT_NEAR(out[i].dx_m - in[i].dx_m, i == 100 ? 5 : 0, 1e-12);
  }
}

TEST(WheelFault, ResetLeadsBackToWhereTheSumWasZero) {
  const auto in = Drive();
  const auto out = With(FaultId::kWheelsReset, in, 100);
  const std::vector<WheelSample> before(out.begin(), out.begin() + 101);
  EXPECT_LT(Apart(Sum(before), SE3()), 1e-9);
  EXPECT_EQ(out[101].dx_m, in[101].dx_m);
}

TEST(WheelFault, DoubledAndNan) {
  const auto in = Drive();
  EXPECT_EQ(With(FaultId::kWheelsDoubled, in, 100).size(), 300u);
  const auto nan = With(FaultId::kWheelsNan, in, 100);
  EXPECT_TRUE(std::isfinite(nan[99].dx_m));
  EXPECT_TRUE(std::isnan(nan[100].dx_m) && std::isnan(nan[100].dyaw_rad));
}

ImuSample Imu(int i) {
  ImuSample s;
  s.utime = {kBegin + i * 5000};
  s.w_I_rad_s = {0.1, 0.2, 0.3};
  s.a_I_m_s2 = {0, 0, 9.80665};
  return s;
}
std::vector<ImuSample> ImuWith(FaultId id) {
  const SampleFault<ImuSample> fault = MakeImuFault(id);
  std::vector<ImuSample> out;
  for (int i = 0; i < 6; ++i) {
    std::vector<Edited<ImuSample>> samples = {{Imu(i), {}}};
    fault(true, samples);
    for (const auto& edited : samples) out.push_back(edited.sample);
  }
  return out;
}

TEST(ImuFault, Units) {
  EXPECT_NEAR(ImuWith(FaultId::kGyroDegrees)[0].w_I_rad_s.z(), 17.1887, 1e-4);
  EXPECT_NEAR(ImuWith(FaultId::kGyroBias)[0].w_I_rad_s.x(), 0.1 + 0.05236, 1e-5);
  EXPECT_NEAR(ImuWith(FaultId::kAccelG)[0].a_I_m_s2.z(), 1, 1e-12);
}

TEST(ImuFault, Stamps) {
  const auto hour = ImuWith(FaultId::kImuHourOff);
  const auto repeat = ImuWith(FaultId::kImuStampsRepeat);
  const auto stuck = ImuWith(FaultId::kImuStampsStuck);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ((hour[i].utime - Imu(i).utime).us, 3'600'000'000);
    EXPECT_EQ(repeat[i].utime, Imu(i / 2 * 2).utime);
    EXPECT_EQ(stuck[i].utime, Imu(0).utime);
  }
}

// The pose of dead reckoning on the same curve.
std::vector<DrState> DrWith(FaultId id, size_t begin) {
  const SampleFault<DrState> fault = MakeDrFault(id);
  std::vector<DrState> out;
  DrState state;
  state.T_OB = SE3(ExpSO3({0, 0, 1}), {3, 4, 0});
  const auto drive = Drive();
  for (size_t i = 0; i < drive.size(); ++i) {
    state.utime = drive[i].utime;
    state.T_OB = state.T_OB * Increment(drive[i]);
    state.v_OB_B = {kSpeed, 0, 0};
    std::vector<Edited<DrState>> states = {{state, {}}};
    fault(i >= begin, states);
    for (const auto& edited : states) out.push_back(edited.sample);
  }
  return out;
}
SE3 Motion(const std::vector<DrState>& states, size_t a, size_t b) {
  return states[a].T_OB.inverse() * states[b].T_OB;
}

TEST(DrFault, WayIsScaledTurnedOrStands) {
  const auto good = DrWith(FaultId::kWheelsNan, 1000);
  EXPECT_NEAR(Motion(DrWith(FaultId::kWheelsDouble, 0), 0, 1).translation().norm(), 0.04, 1e-6);
  EXPECT_NEAR(Motion(DrWith(FaultId::kWheelsReversed, 0), 0, 1).translation().x(), -0.02, 1e-5);
  EXPECT_NEAR(Motion(DrWith(FaultId::kWheelsMillimetres, 0), 0, 1).translation().norm(), 20, 1e-3);
  const auto turned = DrWith(FaultId::kWheelsTurned, 0);
  EXPECT_LT(Apart(Motion(turned, 0, 199), Turn(-M_PI / 2) * Motion(good, 0, 199) * Turn(M_PI / 2)),
            1e-9);
  EXPECT_NEAR(turned.back().v_OB_B.y(), -kSpeed, 1e-12);
  EXPECT_LT(Apart(Motion(DrWith(FaultId::kWheelsStuck, 50), 50, 199), SE3()), 1e-9);
}

TEST(DrFault, JumpsResetsAndStamps) {
  const auto good = DrWith(FaultId::kWheelsNan, 1000);
  const auto jump = DrWith(FaultId::kWheelsJump, 100);
  EXPECT_NEAR(Motion(jump, 99, 100).translation().x(), 5.02, 1e-3);
  EXPECT_LT(Apart(Motion(jump, 100, 199), Motion(good, 100, 199)), 1e-9);
  const auto reset = DrWith(FaultId::kWheelsReset, 100);
  EXPECT_LT(Apart(reset[0].T_OB, reset[100].T_OB), 1e-9);
  EXPECT_LT(Apart(Motion(reset, 100, 199), Motion(good, 100, 199)), 1e-9);
  EXPECT_EQ(DrWith(FaultId::kWheelsLate47, 0)[9].utime - good[9].utime, Milliseconds(47));
  EXPECT_EQ(DrWith(FaultId::kWheelsDoubled, 0).size(), 400u);
  EXPECT_TRUE(std::isnan(DrWith(FaultId::kWheelsNan, 100)[100].T_OB.translation().x()));
}

}  // namespace
}  // namespace gw::fault

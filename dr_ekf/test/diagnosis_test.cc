// What is wrong with the inputs is found, named, and does no harm: each fault in a drive of the
// simulated robot, judged by the motion of the same drive without the fault.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "dr_ekf/test/robot_sim.h"

namespace gw::dr_ekf {
namespace {

struct Outcome {
  std::vector<DrState> states;
  std::vector<DrDiagnosis> found;
  DrCounters counters;

  bool Found(DrDiagnosis diagnosis) const {
    return std::find(found.begin(), found.end(), diagnosis) != found.end();
  }
};

using Fault = std::function<void(ImuSample&)>;
using WheelFault = std::function<void(WheelSample&)>;

Outcome Drive(const Calibration& calibration, const std::vector<Sample>& samples) {
  Outcome out;
  DrFilter filter = std::move(DrFilter::Create({}, calibration)).value();
  for (const Sample& sample : samples) {
    DrFilter::Output o = Feed(filter, sample);
    out.counters = o.counters;
    out.found.insert(out.found.end(), o.found.begin(), o.found.end());
    for (DrState& s : o.states) out.states.push_back(std::move(s));
  }
  return out;
}

Outcome DriveWith(const Recording& r, const Fault& imu_fault, const WheelFault& wheel_fault) {
  std::vector<Sample> samples = r.samples;
  for (Sample& sample : samples) {
    if (auto* imu = std::get_if<ImuSample>(&sample)) {
      imu_fault(*imu);
    } else {
      wheel_fault(std::get<WheelSample>(sample));
    }
  }
  return Drive(r.calibration, samples);
}

void Nothing(WheelSample&) {}

// Largest difference in place to the truth, of the motion since the newest reset (the states are in
// the frame of O from there on as before).
double ErrorSinceReset(const Recording& r, const Outcome& out) {
  const DrState& last = out.states.back();
  size_t first = out.states.size() - 1;
  while (first > 0 && out.states[first - 1].reset_counter == last.reset_counter) --first;
  const DrState& begin = out.states[first];
  const SE3 motion = begin.T_OB.inverse() * last.T_OB;
  const SE3 truth = r.TruthAt(begin.utime).inverse() * r.TruthAt(last.utime);
  return (motion.inverse() * truth).translation().norm();
}

Recording TurnsAndStops() {
  return Simulate(WheelsAndImu(), {}, {.seed = 5, .duration_s = 30});
}

// What dead reckoning without the stream has, and half of that again.
double WheelsAloneError() {
  const Recording r = Simulate(WheelsOnly(), {}, {.seed = 5, .duration_s = 30});
  return ErrorSinceReset(r, Drive(r.calibration, r.samples));
}

TEST(DrDiagnosis, AGoodDriveHasNone) {
  const Recording r = TurnsAndStops();
  const Outcome out = Drive(r.calibration, r.samples);
  EXPECT_TRUE(out.found.empty()) << Text(out.found.front());
  EXPECT_EQ(out.counters.resets, 0);
}

TEST(DrDiagnosis, AccelerationsInGAreScaled) {
  const Recording r = TurnsAndStops();
  const Outcome good = Drive(r.calibration, r.samples);
  const Outcome out = DriveWith(
      r, [](ImuSample& s) { s.a_I_m_s2 /= 9.80665; }, Nothing);
  EXPECT_TRUE(out.Found(DrDiagnosis::kAccelInG));
  EXPECT_TRUE(out.states.back().gravity_aligned);
  EXPECT_LT((out.states.back().T_OB.translation() - good.states.back().T_OB.translation()).norm(),
            1e-3);
}

TEST(DrDiagnosis, AnAccelerometerWithoutGravityIsNotUsed) {
  const Recording r = TurnsAndStops();
  const Eigen::Vector3d up_I =
      r.calibration.imu.T_BI.rotation().conjugate() * Eigen::Vector3d::UnitZ();
  const Outcome out = DriveWith(
      r, [&](ImuSample& s) { s.a_I_m_s2 -= 9.80665 * up_I; }, Nothing);
  EXPECT_TRUE(out.Found(DrDiagnosis::kAccelWithoutGravity));
  EXPECT_FALSE(out.states.back().gravity_aligned);
  EXPECT_LT(ErrorSinceReset(r, out), 0.2);
  EXPECT_LT(std::abs(out.states.back().T_OB.translation().z()), 0.05);
}

TEST(DrDiagnosis, AGyroInDegreesIsNotUsed) {
  const Recording r = TurnsAndStops();
  const Outcome out = DriveWith(
      r, [](ImuSample& s) { s.w_I_rad_s *= 57.29578; }, Nothing);
  EXPECT_TRUE(out.Found(DrDiagnosis::kGyroInDegrees));
  EXPECT_FALSE(out.states.back().imu_alive);
  EXPECT_LT(ErrorSinceReset(r, out), 1.5 * WheelsAloneError() + 0.1);
}

// Long before a full turn: "up" by the gyro is not that of the accelerometer.
TEST(DrDiagnosis, AGyroInDegreesIsFoundAtTheFirstStandstillAndNotBelievedBefore) {
  const Recording r = TurnsAndStops();
  DrFilter filter = std::move(DrFilter::Create({}, r.calibration)).value();
  std::optional<double> found_s;
  double believed = 0;  // rad, that the filter claims to have turned and nobody doubts
  SE3 before;
  for (Sample sample : r.samples) {
    if (found_s) break;
    if (auto* imu = std::get_if<ImuSample>(&sample)) {
      // As large an offset as any gyro has.
      imu->w_I_rad_s = (imu->w_I_rad_s + Eigen::Vector3d(0.01, -0.01, 0.01)) * 57.29578;
    }
    const DrFilter::Output out = Feed(filter, sample);
    for (const DrState& state : out.states) {
      const double turned = LogSO3((before.inverse() * state.T_OB).rotation()).norm();
      const bool early = (state.utime - r.begin).seconds() < 0.4;
      if (!state.slip && !early && state.reset_counter == 0) believed += turned;
      before = state.T_OB;
    }
    if (std::find(out.found.begin(), out.found.end(), DrDiagnosis::kGyroInDegrees) !=
        out.found.end()) {
      found_s = (std::visit([](const auto& s) { return s.utime; }, sample) - r.begin).seconds();
    }
  }
  ASSERT_TRUE(found_s);
  EXPECT_LT(*found_s, 2.5);
  EXPECT_LT(believed, 0.02);
}

TEST(DrDiagnosis, AFrozenGyroIsNotUsed) {
  const Recording r = TurnsAndStops();
  const Outcome out = DriveWith(
      r, [](ImuSample& s) { s.w_I_rad_s = Eigen::Vector3d(0.001, 0.002, 0.003); }, Nothing);
  EXPECT_TRUE(out.Found(DrDiagnosis::kGyroFrozen));
  EXPECT_LT(ErrorSinceReset(r, out), 1.5 * WheelsAloneError() + 0.1);
}

TEST(DrDiagnosis, AnImuOnAnotherClockIsNotUsed) {
  const Recording r = TurnsAndStops();
  for (const int64_t hours : {-1, 1}) {
    const Outcome out = DriveWith(
        r, [&](ImuSample& s) { s.utime.us += hours * 3'600'000'000; }, Nothing);
    EXPECT_TRUE(out.Found(DrDiagnosis::kImuOnAnotherClock)) << hours;
    EXPECT_LT(std::abs((out.states.back().utime - r.begin).seconds() - 30), 0.1) << hours;
    EXPECT_LT(ErrorSinceReset(r, out), 1.5 * WheelsAloneError() + 0.1) << hours;
  }
}

TEST(DrDiagnosis, ImuStampsThatStandAreNamedAndTheWheelsGoOn) {
  const Recording r = TurnsAndStops();
  const Utime stuck = r.begin + Milliseconds(3000);
  const Outcome out = DriveWith(
      r, [&](ImuSample& s) { s.utime = std::min(s.utime, stuck); }, Nothing);
  EXPECT_TRUE(out.Found(DrDiagnosis::kImuStampsRepeat));
  EXPECT_FALSE(out.states.back().imu_alive);
  EXPECT_GT((out.states.back().utime - r.begin).seconds(), 29.9);
  EXPECT_LT(ErrorSinceReset(r, out), 1.5 * WheelsAloneError() + 0.1);
}

TEST(DrDiagnosis, AStuckHeadingOfTheBaseIsNotBelieved) {
  for (const double from_s : {0.0, 8.0}) {
    const Recording r =
        Simulate(WheelsOnly(), {}, {.seed = 5, .duration_s = 30, .with_heading = true});
    std::optional<double> held;
    const Outcome out = DriveWith(
        r, [](ImuSample&) {},
        [&](WheelSample& s) {
          if ((s.utime - r.begin).seconds() < from_s) return;
          if (!held) held = s.heading_rad;
          s.heading_rad = *held;
        });
    EXPECT_TRUE(out.Found(DrDiagnosis::kHeadingStuck)) << from_s;
    EXPECT_LT(ErrorSinceReset(r, out), 1.5 * WheelsAloneError() + 0.1) << from_s;
  }
}

TEST(DrDiagnosis, WheelsWhoseHeadingIsStuckDoNotHoldTheGyro) {
  const Recording r = TurnsAndStops();
  const Outcome good = Drive(r.calibration, r.samples);
  const Outcome out = DriveWith(
      r, [](ImuSample&) {},
      [](WheelSample& s) {
        s.dx_m = std::copysign(std::hypot(s.dx_m, s.dy_m), s.dx_m);
        s.dy_m = s.dyaw_rad = 0;
      });
  EXPECT_TRUE(out.Found(DrDiagnosis::kWheelTurnStuck));
  const SE3 apart = good.states.back().T_OB.inverse() * out.states.back().T_OB;
  EXPECT_LT(std::abs(apart.Log()[5]), 0.1);
}

// Seconds after the begin at which what is tried once happens.
constexpr double kOnceAt = 12;

// True for the first sample at or after kOnceAt.
class Once {
 public:
  bool operator()(const Recording& r, Utime utime) {
    return (utime - r.begin).seconds() >= kOnceAt && !std::exchange(done_, true);
  }

 private:
  bool done_ = false;
};

// Encoders that are not heard: the turn goes on by the gyro, and neither sensor is blamed for the
// other's silence. The reverse, wheels that turn while the robot stands, is slip (slip_test).
TEST(DrDiagnosis, WheelsThatStandWhileTheRobotDrivesAreNamed) {
  const Recording r = Simulate(WheelsAndImu(), {}, {.seed = 5, .duration_s = 40, .stops = false});
  const Utime from = r.begin + Milliseconds(15000);
  const Outcome out = DriveWith(
      r, [](ImuSample&) {},
      [&](WheelSample& s) {
        if (s.utime > from) s.dx_m = s.dy_m = s.dyaw_rad = 0;
      });
  EXPECT_TRUE(out.Found(DrDiagnosis::kWheelsStand));
  EXPECT_FALSE(out.Found(DrDiagnosis::kAccelUnfit));
  EXPECT_FALSE(out.Found(DrDiagnosis::kTrackIsOther));
  EXPECT_FALSE(out.Found(DrDiagnosis::kWheelTurnStuck));
  const SE3 last = out.states.front().T_OB.inverse() * out.states.back().T_OB;
  const SE3 truth =
      r.TruthAt(out.states.front().utime).inverse() * r.TruthAt(out.states.back().utime);
  EXPECT_LT(std::abs(LogSO3(last.rotation().conjugate() * truth.rotation()).z()), 0.1);
}

TEST(DrDiagnosis, EverySecondImuStampRepeatedIsNamed) {
  const Recording r = TurnsAndStops();
  Utime before;
  bool second = false;
  const Outcome out = DriveWith(
      r,
      [&](ImuSample& s) {
        if (second) s.utime = before;
        second = !second;
        before = s.utime;
      },
      Nothing);
  EXPECT_TRUE(out.Found(DrDiagnosis::kImuStampsRepeat));
  EXPECT_LT(ErrorSinceReset(r, out), 1.5 * WheelsAloneError() + 0.1);
}

TEST(DrDiagnosis, ValuesThatAreNoNumbersAreLeftOutAndNamed) {
  const Recording r = TurnsAndStops();
  const double error = ErrorSinceReset(r, Drive(r.calibration, r.samples));
  const double nan = std::nan("");
  Once once;
  const Outcome imu = DriveWith(
      r,
      [&](ImuSample& s) {
        if (once(r, s.utime)) s.w_I_rad_s.y() = nan;
      },
      Nothing);
  EXPECT_EQ(imu.found, std::vector{DrDiagnosis::kImuNotNumbers});
  EXPECT_LT(ErrorSinceReset(r, imu), error + 0.02);
  Once again;
  const Outcome wheels = DriveWith(
      r, [](ImuSample&) {},
      [&](WheelSample& s) {
        if (again(r, s.utime)) s.dyaw_rad = nan;
      });
  EXPECT_EQ(wheels.found, std::vector{DrDiagnosis::kWheelsNotNumbers});
  EXPECT_LT(ErrorSinceReset(r, wheels), error + 0.02);
}

TEST(DrDiagnosis, WheelsThatJumpOnceAreNotWheelsInAnotherUnit) {
  const Recording r = TurnsAndStops();
  Once once;
  const Outcome jump = DriveWith(
      r, [](ImuSample&) {},
      [&](WheelSample& s) {
        if (once(r, s.utime)) s.dx_m += 5;
      });
  EXPECT_EQ(jump.found, std::vector{DrDiagnosis::kWheelsJumped});
  EXPECT_LT(ErrorSinceReset(r, jump), 1.5 * WheelsAloneError() + 0.1);
  const Outcome millimetres = DriveWith(
      r, [](ImuSample&) {}, [](WheelSample& s) { s.dx_m *= 1000, s.dy_m *= 1000; });
  EXPECT_TRUE(millimetres.Found(DrDiagnosis::kWheelsTooFast));
}

TEST(DrDiagnosis, WheelsThatComeTwiceAreNamedAndUsedOnce) {
  const Recording r = TurnsAndStops();
  const Outcome good = Drive(r.calibration, r.samples);
  std::vector<Sample> samples;
  for (const Sample& sample : r.samples) {
    samples.push_back(sample);
    if (std::holds_alternative<WheelSample>(sample)) samples.push_back(sample);
  }
  const Outcome out = Drive(r.calibration, samples);
  EXPECT_EQ(out.found, std::vector{DrDiagnosis::kWheelsTwice});
  EXPECT_EQ(out.states.back().T_OB.translation(), good.states.back().T_OB.translation());
}

TEST(DrDiagnosis, ABiasBeyondTheDataSheetIsNamedAndTakenOut) {
  const Recording r = TurnsAndStops();
  const double error = ErrorSinceReset(r, Drive(r.calibration, r.samples));
  const Outcome out = DriveWith(
      r, [](ImuSample& s) { s.w_I_rad_s += Eigen::Vector3d::Constant(0.08); }, Nothing);
  EXPECT_TRUE(out.Found(DrDiagnosis::kGyroBiasLarge));
  EXPECT_LT(ErrorSinceReset(r, out), 1.5 * error + 0.1);
}

TEST(DrDiagnosis, WheelsThatTurnTheOtherWayAreTurnedRound) {
  const Recording r = TurnsAndStops();
  const Outcome good = Drive(r.calibration, r.samples);
  const Outcome out = DriveWith(
      r, [](ImuSample&) {}, [](WheelSample& s) { s.dy_m = -s.dy_m, s.dyaw_rad = -s.dyaw_rad; });
  EXPECT_TRUE(out.Found(DrDiagnosis::kWheelsTurnBackwards));
  EXPECT_LT(ErrorSinceReset(r, out), 1.5 * ErrorSinceReset(r, good) + 0.1);
  EXPECT_NEAR(out.states.back().gyro_bias_rad_s.z(), good.states.back().gyro_bias_rad_s.z(), 2e-3);
}

// ---- The track --------------------------------------------------------------------------------

TEST(DrTrack, AWrongTrackIsEstimatedAndIsNeitherSlipNorBias) {
  for (const auto calibration : {WheelsAndGyro, WheelsAndImu}) {
    for (const double factor : {0.3, 0.5, 0.7, 1.5, 3.0}) {
      SimOptions options{.seed = 7, .duration_s = 40};
      options.true_yaw_scale = factor;
      const Recording r = Simulate(calibration(), {}, options);
      const Outcome out = Drive(r.calibration, r.samples);
      EXPECT_TRUE(out.Found(DrDiagnosis::kTrackIsOther)) << factor;
      const DrState& last = out.states.back();
      const SE3 truth = r.T_GB.front().inverse() * r.TruthAt(last.utime);
      EXPECT_LT(std::abs((last.T_OB.inverse() * truth).Log()[5]), 0.05) << factor;
      EXPECT_LT(last.gyro_bias_rad_s.norm(), 0.01) << factor;
      EXPECT_EQ(out.counters.step.slips, 0) << factor;
    }
  }
}

// ---- The clock --------------------------------------------------------------------------------

struct Jump {
  const char* name;
  int64_t us;
  bool restarts;
};
void PrintTo(const Jump& jump, std::ostream* os) {
  *os << jump.name;
}
class DrClock : public testing::TestWithParam<Jump> {};
INSTANTIATE_TEST_SUITE_P(Jumps, DrClock,
                         testing::Values(Jump{"back_10s", -10'000'000, true},
                                         Jump{"back_50ms", -50'000, false},
                                         Jump{"ahead_1h", 3'600'000'000, true},
                                         Jump{"ahead_5s", 5'000'000, false}),
                         [](const auto& test) { return test.param.name; });

TEST_P(DrClock, AJumpIsARestartWithinASecondAndNamed) {
  for (const auto calibration : {WheelsOnly, WheelsAndImu}) {
    const Recording r = Simulate(calibration(), {}, {.seed = 5, .duration_s = 20});
    const double at_s = 12;
    std::vector<Sample> samples = r.samples;
    const auto moved = [&](Utime t) {
      return (t - r.begin).seconds() < at_s ? t : t + DurationUs{GetParam().us};
    };
    for (Sample& sample : samples) {
      if (auto* imu = std::get_if<ImuSample>(&sample)) {
        imu->utime = moved(imu->utime);
      } else {
        auto& wheel = std::get<WheelSample>(sample);
        wheel.utime = moved(wheel.utime);
        wheel.utime_begin = moved(wheel.utime_begin);
      }
    }
    DrFilter filter = std::move(DrFilter::Create({}, r.calibration)).value();
    std::vector<DrDiagnosis> found;
    double longest_silence = 0, last_state = 0, now = 0;
    DrState last;
    for (size_t i = 0; i < samples.size(); ++i) {
      now = (std::visit([](const auto& s) { return s.utime; }, r.samples[i]) - r.begin).seconds();
      const DrFilter::Output out = Feed(filter, samples[i]);
      found.insert(found.end(), out.found.begin(), out.found.end());
      if (out.states.empty()) continue;
      longest_silence = std::max(longest_silence, now - last_state);
      last_state = now;
      last = out.states.back();
    }
    EXPECT_LT(longest_silence, 1.0);
    EXPECT_LT(now - last_state, 0.1);
    if (!GetParam().restarts) {  // a few seconds ahead: all were silent, and the wheels bridge it
      EXPECT_EQ(last.reset_counter, 0u);
      continue;
    }
    EXPECT_EQ(last.reset_counter, 1u);
    const DrDiagnosis expected =
        GetParam().us < 0 ? DrDiagnosis::kTimeWentBack : DrDiagnosis::kTimeJumpedAhead;
    EXPECT_EQ(std::count(found.begin(), found.end(), expected), 1);
    EXPECT_LT(std::sqrt(last.cov_T_OB(0, 0)), 3);  // no hour of dead reckoning
  }
}

}  // namespace
}  // namespace gw::dr_ekf

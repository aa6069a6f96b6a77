#include "tools/data/import/imu_check.h"

#include <algorithm>
#include <cmath>

#include "tools/data/files/format.h"
#include "tools/data/import/turn_match.h"

namespace gw::importer {
namespace {

using tools::Format;

constexpr double kStandardGravity = 9.80665;  // m/s^2; CGPM 1901
constexpr double kDegrees = 180 / M_PI;
// Turning that is needed before turns can decide anything: half a right angle.
constexpr double kEnoughTurn = 0.8;
constexpr double kFollows =
    0.5;  // correlation: noise has 0, an unsteady clock still more than this
// A wheel base tells turns up to three times too large or small (track of a skid-steer base), so
// that gyro over wheels is 0.33 to 3 in rad/s and 19 to 172 in deg/s: the middle, on a log scale.
constexpr double kLeastDegreesScale = 7.5;
// No MEMS gyro measures beyond 2000 deg/s = 34.9 rad/s.
constexpr double kLargestGyro = 35;
// Norm of the accelerometer at rest: within 15 % it is gravity in a unit (bias and scale of a bad
// accelerometer are 5 %). Half and double of it decide alike: the units are a factor of 9.8 apart.
constexpr double kGravityTolerance = 0.15;
constexpr double kGravityRemoved = 0.06;  // of gravity: what a bias may leave
// On a floor the body's z is up; a mounting is known to some degrees. Beyond a third of a right
// angle T_BI is wrong.
constexpr double kLargestTilt = 0.5;  // rad

void Warn(Recording& recording, const std::string& text) {
  recording.warnings.push_back("IMU: " + text);
}

void DropAccel(Recording& recording) {
  for (ImuSample& sample : recording.imu) {
    sample.has_accel = false;
    sample.a_I_m_s2.setZero();
  }
}

struct Span {
  Utime begin, end;
};

// Name and span of the stream that the IMU has to share its clock with.
std::optional<std::pair<std::string, Span>> OtherClock(const Recording& recording) {
  if (!recording.wheel.empty()) {
    return std::pair{"the wheels'",
                     Span{recording.wheel.front().utime_begin, recording.wheel.back().utime}};
  }
  if (recording.frames && recording.frames->size() > 0) {
    return std::pair{"the images'", Span{recording.frames->utime(0),
                                         recording.frames->utime(recording.frames->size() - 1)}};
  }
  if (!recording.ground_truth.empty()) {
    return std::pair{"the ground truth's", Span{recording.ground_truth.front().utime,
                                                recording.ground_truth.back().utime}};
  }
  return std::nullopt;
}

void LeaveOut(Recording& recording, const std::string& why) {
  Warn(recording, why + "; the IMU is left out");
  recording.imu.clear();
}

// False when the IMU was left out.
bool CheckClock(const TurnReference& reference, Recording& recording) {
  const Eigen::Quaterniond R_BI = recording.calibration.imu.T_BI.rotation();
  const TurnMatcher matcher(reference, recording.imu);
  const bool turns = reference.turned_rad > kEnoughTurn;
  const auto advice = [](DurationUs offset) {
    return Format("another clock? If so, --imu-time-offset %.2f", offset.seconds());
  };
  const auto other = OtherClock(recording);
  const Span imu = {recording.imu.front().utime, recording.imu.back().utime};
  if (other && (imu.end < other->second.begin || imu.begin > other->second.end)) {
    const DurationUs by_begins = imu.begin - other->second.begin;
    const auto by_turns = turns ? matcher.FindOffset(R_BI, by_begins) : std::nullopt;
    LeaveOut(recording, Format("its times (%.3f to %.3f s) have nothing in common with ",
                               imu.begin.seconds(), imu.end.seconds()) +
                            other->first +
                            Format(" (%.3f to %.3f s): ", other->second.begin.seconds(),
                                   other->second.end.seconds()) +
                            advice(by_turns.value_or(by_begins)) +
                            (by_turns ? " (by matching turns)" : " (if both began together)"));
    return false;
  }
  if (!turns) return true;
  const auto now = matcher.Fit(R_BI, {0});
  if (now && std::abs(now->correlation) >= kFollows) return true;
  const auto offset = matcher.FindOffset(R_BI, {0});
  if (!offset) return true;
  LeaveOut(recording, "the gyro turns with the " + reference.name +
                          Format(" only when its times are moved by %.2f s: ", -offset->seconds()) +
                          advice(*offset));
  return false;
}

void ConvertGyro(const std::string& why, Recording& recording) {
  for (ImuSample& sample : recording.imu) sample.w_I_rad_s /= kDegrees;
  Warn(recording, "the gyro is in deg/s (" + why + "); converted to rad/s");
}

// Turns about another axis of the IMU than T_BI says.
void NameTurningAxis(const TurnReference& reference, const TurnMatcher& matcher,
                     Recording& recording) {
  std::string found;
  if (reference.planar) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto R_BI =
          Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::Unit(axis), Eigen::Vector3d::UnitZ());
      const auto fit = matcher.Fit(R_BI, {0});
      if (!fit || std::abs(fit->correlation) < 0.9) continue;
      found = Format("; they are on its %s%c axis", fit->scale < 0 ? "-" : "", "xyz"[axis]);
    }
  }
  Warn(recording,
       "the gyro does not follow the turns of the " + reference.name + found +
           ": is T_BI right, and is it of this drive? Correct it, or do without the IMU");
}

// Returns whether turns show that the gyro's axis is right.
bool CheckGyro(const ImuCheckOptions& options, const TurnReference& reference,
               Recording& recording) {
  if (options.gyro_unit == GyroUnit::kDegPerS) ConvertGyro("as stated", recording);
  const TurnMatcher matcher(reference, recording.imu);
  const auto fit = reference.turned_rad > kEnoughTurn
                       ? matcher.Fit(recording.calibration.imu.T_BI.rotation(), {0})
                       : std::nullopt;
  if (!fit || fit->turned_rad < kEnoughTurn) {
    double largest = 0;
    for (const ImuSample& sample : recording.imu) {
      largest = std::max(largest, sample.w_I_rad_s.cwiseAbs().maxCoeff());
    }
    if (largest > kLargestGyro && options.gyro_unit == GyroUnit::kAuto) {
      ConvertGyro(Format("it reaches %.0f, and no gyro measures %.0f rad/s", largest, largest),
                  recording);
    }
    return false;
  }
  if (std::abs(fit->correlation) < kFollows) {
    NameTurningAxis(reference, matcher, recording);
    return false;
  }
  if (fit->scale < 0) {
    Warn(recording, "the gyro turns against the " + reference.name +
                        Format(" (factor %.2f): T_BI or the sign of the gyro is wrong; correct it",
                               fit->scale));
    return false;
  }
  if (fit->scale > kLeastDegreesScale && options.gyro_unit == GyroUnit::kAuto) {
    ConvertGyro(Format("it turns %.1f times as much as the ", fit->scale) + reference.name,
                recording);
  } else if (fit->scale > kLeastDegreesScale) {
    Warn(recording, Format("the gyro turns %.1f times as much as the ", fit->scale) +
                        reference.name + ": is its unit as stated?");
  }
  return true;
}

// The accelerometer in the quietest tenth of the half-seconds.
struct RestingAccel {
  double norm =
      0;  // mean of the half-seconds' norms: also of a camera that is held in any attitude
  Eigen::Vector3d mean_I = Eigen::Vector3d::Zero();
};

// Empty with fewer than ten samples.
std::optional<RestingAccel> AccelAtRest(const std::vector<ImuSample>& imu) {
  struct Window {
    double variance;
    Eigen::Vector3d mean;
  };
  std::vector<Window> windows;
  std::vector<Eigen::Vector3d> values;
  const auto close = [&] {
    if (values.size() >= 10) {
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (const Eigen::Vector3d& a : values) mean += a;
      mean /= static_cast<double>(values.size());
      double variance = 0;
      for (const Eigen::Vector3d& a : values) variance += (a - mean).squaredNorm();
      windows.push_back({variance / static_cast<double>(values.size()), mean});
    }
    values.clear();
  };
  Utime begin;
  for (const ImuSample& sample : imu) {
    if (!sample.has_accel) continue;
    if (values.empty()) begin = sample.utime;
    values.push_back(sample.a_I_m_s2);
    if (sample.utime - begin >= Milliseconds(500)) close();
  }
  close();
  if (windows.empty()) return std::nullopt;
  std::stable_sort(windows.begin(), windows.end(),
                   [](const Window& a, const Window& b) { return a.variance < b.variance; });
  windows.resize(std::max<size_t>(windows.size() / 10, 1));
  RestingAccel rest;
  for (const Window& window : windows) {
    rest.norm += window.mean.norm() / static_cast<double>(windows.size());
    rest.mean_I += window.mean / static_cast<double>(windows.size());
  }
  return rest;
}

void ScaleAccel(double factor, Recording& recording) {
  for (ImuSample& sample : recording.imu) sample.a_I_m_s2 *= factor;
}

// The unit by the norm at rest; false when the accelerometer was left out.
bool CheckAccelUnit(const ImuCheckOptions& options, double norm, Recording& recording) {
  const auto near = [&](double gravity) {
    return std::abs(norm / gravity - 1) < kGravityTolerance;
  };
  if (options.accel_unit == AccelUnit::kG) {
    ScaleAccel(kStandardGravity, recording);
    Warn(recording, "the accelerometer is in g (as stated); converted to m/s^2");
    norm *= kStandardGravity;
  } else if (options.accel_unit == AccelUnit::kAuto && (near(1) || near(1000))) {
    const bool milli = near(1000);
    ScaleAccel(kStandardGravity / (milli ? 1000 : 1), recording);
    Warn(recording, Format("the accelerometer is in %s (its norm at rest is %.3f); converted to "
                           "m/s^2",
                           milli ? "mg" : "g", norm));
    return true;
  }
  if (near(kStandardGravity)) return true;
  DropAccel(recording);
  if (norm < kGravityRemoved * kStandardGravity) {
    Warn(recording,
         Format("the accelerometer shows no gravity (norm at rest %.3f): it was removed, "
                "or never measured; the accelerometer is left out",
                norm));
  } else {
    Warn(
        recording,
        Format("the accelerometer's norm at rest is %.3f, which is gravity neither in m/s^2 nor in "
               "g; the accelerometer is left out (--accel-unit states its unit)",
               norm));
  }
  return false;
}

// On wheels the body's z is up.
void CheckUp(const Eigen::Vector3d& rest_I, bool gyro_axis_is_right, Recording& recording) {
  const Eigen::Vector3d rest_B = recording.calibration.imu.T_BI.rotation() * rest_I.normalized();
  const double tilt = std::acos(std::clamp(rest_B.z(), -1.0, 1.0));
  if (tilt < kLargestTilt) return;
  if (M_PI - tilt < kLargestTilt && gyro_axis_is_right) {
    ScaleAccel(-1, recording);
    Warn(recording,
         "the accelerometer points down at rest while the gyro turns as the wheels do: it shows "
         "gravity, not specific force; its sign was changed");
    return;
  }
  DropAccel(recording);
  Warn(recording,
       Format("at rest the accelerometer points %.0f deg away from the body's z, which is up on "
              "wheels: is T_BI (or the wheels' frame) right? The accelerometer is left out",
              kDegrees * tilt));
}

}  // namespace

void CheckImu(const ImuCheckOptions& options, Recording& recording) {
  if (recording.imu.empty()) return;
  if (options.time_offset_s != 0) {
    const DurationUs offset = DurationFromSeconds(options.time_offset_s);
    for (ImuSample& sample : recording.imu) sample.utime = sample.utime - offset;
    recording.notes.emplace_back(
        "imu", Format("times moved by %.6f s (--imu-time-offset)", -options.time_offset_s));
  }
  const TurnReference reference = MakeTurnReference(recording);
  if (!CheckClock(reference, recording)) return;
  const bool axis_is_right = CheckGyro(options, reference, recording);
  const auto rest = AccelAtRest(recording.imu);
  if (!rest || !CheckAccelUnit(options, rest->norm, recording)) return;
  if (!recording.wheel.empty()) CheckUp(rest->mean_I, axis_is_right, recording);
}

}  // namespace gw::importer

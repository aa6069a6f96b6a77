#include "tools/lab/calibrate/imu_noise.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/core/median.h"
#include "tools/data/files/format.h"

namespace gw::calibrate {
namespace {

using Eigen::Vector3d;
using tools::Format;

constexpr double kDegrees = 180 / M_PI;
constexpr double kStandardGravity = 9.80665;  // m/s^2; CGPM 1901
constexpr double kLongestHole = 0.1;          // s; a dozen samples, filled by a straight line
// A second moves when its mean leaves the usual one by more than this, which is above what a bias
// drifts in an hour (0.6 deg/s; 0.9 degrees of tilt) and below what people notice as a motion.
constexpr double kGyroMoves = 0.01;   // rad/s
constexpr double kAccelMoves = 0.15;  // m/s^2
constexpr double kWheelMoves = 1e-4;  // m or rad in one interval: noise of odometry in metres
constexpr double kLargestBias =
    0.1;  // rad/s: above the zero-rate offset of MEMS gyros (BMI055: 1 deg/s)

struct Second {
  size_t begin = 0, end = 0;  // samples
  Vector3d gyro, accel;       // means
  bool still = true;
};

double MedianSpacing(const std::vector<ImuSample>& imu) {
  std::vector<double> spacings;
  for (size_t i = 1; i < imu.size(); ++i) {
    spacings.push_back((imu[i].utime - imu[i - 1].utime).seconds());
  }
  return MedianOf(&spacings);
}

std::vector<Second> CutIntoSeconds(const std::vector<ImuSample>& imu) {
  std::vector<Second> seconds;
  size_t begin = 0;
  for (size_t i = 1; i <= imu.size(); ++i) {
    const bool hole = i < imu.size() && (imu[i].utime - imu[i - 1].utime).seconds() > kLongestHole;
    const bool full = i < imu.size() && (imu[i].utime - imu[begin].utime).seconds() >= 1;
    if (i < imu.size() && !hole && !full) continue;
    Second second{begin, i, Vector3d::Zero(), Vector3d::Zero(), full};
    for (size_t k = begin; k < i; ++k) {
      second.gyro += imu[k].w_I_rad_s / static_cast<double>(i - begin);
      second.accel += imu[k].a_I_m_s2 / static_cast<double>(i - begin);
    }
    seconds.push_back(second);
    begin = i;
  }
  return seconds;
}

Vector3d MedianSecond(const std::vector<Second>& seconds, Vector3d Second::*mean) {
  Vector3d out;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    values.reserve(seconds.size());
    for (const Second& second : seconds) values.push_back((second.*mean)[axis]);
    out[axis] = MedianOf(&values);
  }
  return out;
}

bool WheelMoves(const WheelSample& sample) {
  return std::abs(sample.dx_m) > kWheelMoves || std::abs(sample.dyaw_rad) > kWheelMoves;
}

void MarkMotion(const std::vector<ImuSample>& imu, const std::vector<WheelSample>& wheels,
                std::vector<Second>& seconds) {
  const Vector3d gyro = MedianSecond(seconds, &Second::gyro);
  const Vector3d accel = MedianSecond(seconds, &Second::accel);
  size_t wheel = 0;
  for (Second& second : seconds) {
    second.still = second.still && (second.gyro - gyro).norm() < kGyroMoves &&
                   (second.accel - accel).norm() < kAccelMoves;
    const Utime end = imu[second.end - 1].utime;
    for (; wheel < wheels.size() && wheels[wheel].utime <= end; ++wheel) {
      if (wheels[wheel].utime >= imu[second.begin].utime && WheelMoves(wheels[wheel])) {
        second.still = false;
      }
    }
  }
}

// The longest run of still seconds, as a range of samples.
std::pair<size_t, size_t> LongestStandstill(const std::vector<Second>& seconds) {
  std::pair<size_t, size_t> longest{0, 0};
  size_t begin = 0;
  for (size_t i = 0; i < seconds.size(); ++i) {
    const bool goes_on =
        i > 0 && seconds[i - 1].still && seconds[i].still && seconds[i - 1].end == seconds[i].begin;
    if (!goes_on) begin = seconds[i].begin;
    if (seconds[i].still && seconds[i].end - begin > longest.second - longest.first) {
      longest = {begin, seconds[i].end};
    }
  }
  return longest;
}

// One component at equal distances, lost samples interpolated.
std::vector<double> Evenly(const std::vector<ImuSample>& imu, std::pair<size_t, size_t> range,
                           double dt, const std::function<double(const ImuSample&)>& component) {
  std::vector<double> out;
  for (size_t i = range.first; i < range.second; ++i) {
    const double value = component(imu[i]);
    if (i > range.first) {
      const double gap = (imu[i].utime - imu[i - 1].utime).seconds();
      const auto missing = std::max<int64_t>(0, std::llround(gap / dt) - 1);
      const double before = out.back();
      for (int64_t k = 1; k <= missing; ++k) {
        out.push_back(before +
                      (value - before) * static_cast<double>(k) / static_cast<double>(missing + 1));
      }
    }
    out.push_back(value);
  }
  return out;
}

TriadNoise MeasureTriad(const std::vector<ImuSample>& imu, std::pair<size_t, size_t> range,
                        double dt, Vector3d ImuSample::*reading) {
  TriadNoise out;
  for (int axis = 0; axis < 3; ++axis) {
    const auto values =
        Evenly(imu, range, dt, [&](const ImuSample& sample) { return (sample.*reading)[axis]; });
    for (const double value : values) out.mean[axis] += value / static_cast<double>(values.size());
    out.axes[static_cast<size_t>(axis)] = FitNoise(AllanVariance(values, dt));
  }
  return out;
}

double Largest(const TriadNoise& sensor, NoiseTerm NoiseModel::*term, double given) {
  double largest = 0;
  for (const NoiseModel& axis : sensor.axes) {
    if ((axis.*term).determined()) largest = std::max(largest, (axis.*term).value);
  }
  return largest > 0 ? largest : given;
}

}  // namespace

Result<ImuNoise> MeasureImuNoise(const std::vector<ImuSample>& imu,
                                 const std::vector<WheelSample>& wheels) {
  if (imu.size() < 100) {
    return Error{ErrorCode::kBadData, "the recording has " + std::to_string(imu.size()) +
                                          " IMU samples: is the IMU's driver on?"};
  }
  std::vector<Second> seconds = CutIntoSeconds(imu);
  MarkMotion(imu, wheels, seconds);
  const auto range = LongestStandstill(seconds);
  ImuNoise out;
  if (range.second > range.first) {
    out.parked_s = (imu[range.second - 1].utime - imu[range.first].utime).seconds();
  }
  if (out.parked_s < kShortestParked) {
    return Error{
        ErrorCode::kBadData,
        Format("the longest standstill lasts %.0f s; record the robot for an hour while it "
               "stands, everything switched on, nobody near it",
               out.parked_s)};
  }
  const std::vector<ImuSample> parked(imu.begin() + static_cast<std::ptrdiff_t>(range.first),
                                      imu.begin() + static_cast<std::ptrdiff_t>(range.second));
  const double dt = MedianSpacing(parked);
  out.rate_hz = 1 / dt;
  out.filled = std::llround(out.parked_s / dt) + 1 - std::ssize(parked);
  const bool dead = std::all_of(parked.begin(), parked.end(), [&](const ImuSample& sample) {
    return sample.w_I_rad_s == parked.front().w_I_rad_s;
  });
  if (dead) {
    return Error{ErrorCode::kBadData,
                 "the gyro reads the same in every sample: it is dead, or its "
                 "driver repeats one reading"};
  }
  const std::pair<size_t, size_t> all{0, parked.size()};
  out.gyro = MeasureTriad(parked, all, dt, &ImuSample::w_I_rad_s);
  out.has_accel = std::all_of(parked.begin(), parked.end(),
                              [](const ImuSample& sample) { return sample.has_accel; });
  if (out.has_accel) out.accel = MeasureTriad(parked, all, dt, &ImuSample::a_I_m_s2);
  return out;
}

double LargestDensity(const TriadNoise& sensor, double given) {
  return Largest(sensor, &NoiseModel::density, given);
}

double LargestWalk(const TriadNoise& sensor, double given) {
  return Largest(sensor, &NoiseModel::walk, given);
}

ImuCalibration WithNoise(const ImuCalibration& given, const ImuNoise& found) {
  ImuCalibration out = given;
  out.gyro_noise = LargestDensity(found.gyro, given.gyro_noise);
  out.gyro_walk = LargestWalk(found.gyro, given.gyro_walk);
  if (found.has_accel) {
    out.accel_noise = LargestDensity(found.accel, given.accel_noise);
    out.accel_walk = LargestWalk(found.accel, given.accel_walk);
  }
  return out;
}

std::vector<std::string> JudgeStandstill(const ImuNoise& found, const Calibration& given) {
  std::vector<std::string> out;
  const double bias = found.gyro.mean.norm();
  if (bias > kLargestBias) {
    out.push_back(Format(
        "the gyro reads %.3f at rest: as rad/s that is %.1f deg/s, more than the offset of a "
        "sound gyro. Degrees? (gw-import --gyro-unit deg/s) Or was it on a moving thing?",
        bias, bias * kDegrees));
  }
  const double share = found.rate_hz / given.imu.rate_hz;
  if (std::abs(share - 1) > 0.1) {
    out.push_back(Format("the IMU comes at %.1f Hz, calibration.imu.rate_hz says %.1f",
                         found.rate_hz, given.imu.rate_hz));
  }
  if (!found.has_accel) return out;
  const double gravity = found.accel.mean.norm();
  if (gravity < 0.06 * kStandardGravity) {
    out.push_back(
        Format("the accelerometer reads %.2f m/s^2 at rest: gravity was taken off. Record "
               "the raw one, or set has_accel: false",
               gravity));
    return out;
  }
  // Scale and bias of MEMS accelerometers (BMI055: 70 mg) stay below a tenth.
  if (std::abs(gravity - kStandardGravity) > 0.1 * kStandardGravity) {
    out.push_back(Format("the accelerometer reads %.3f at rest, gravity is 9.81 m/s^2%s", gravity,
                         std::abs(gravity - 1) < 0.1 ? ": it counts in g (--accel-unit g)" : ""));
  }
  const Vector3d up_B = given.imu.T_BI.rotation() * found.accel.mean.normalized();
  const double tilt = std::acos(std::clamp(up_B.z(), -1.0, 1.0)) * kDegrees;
  if (tilt > 5) {
    out.push_back(
        Format("gravity is %.1f deg off the body's z (in the body's axes %.2f %.2f %.2f): "
               "correct the rotation of calibration.imu.T_BI, or park on a level floor",
               tilt, up_B.x(), up_B.y(), up_B.z()));
  }
  return out;
}

}  // namespace gw::calibrate

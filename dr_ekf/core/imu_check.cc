#include "dr_ekf/core/imu_check.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/core/se3.h"
#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {
namespace {

// Gravity as consumer parts measure it: scale and bias of a few percent. In units of the sensor;
// what lies between the bands is no unit that anyone uses.
constexpr double kLeastGravity = 0.7, kMostGravity = 1.3;  // of g
constexpr double kNoGravity = 0.3;                         // of g, in g or below in m/s^2
constexpr double kUnitMemory = 1.0;                        // s
// Two channels of one machine are together within its delays; a clock of its own is off by more.
constexpr DurationUs kFarApart = Milliseconds(2000);
constexpr DurationUs kApartFor = Milliseconds(400);
constexpr int kApartSamples = 10;
// The largest offset of MEMS gyros is 0.1 rad/s (data sheets: 5 deg/s); under still wheels in deg/s
// the same offset reads 57 times as large.
constexpr double kMostRestRate = 0.2;  // rad/s
constexpr double kRestFor = 1.0;       // s
constexpr double kDoubtFor = 0.3;      // s: wheels that hardly begin to turn stand for as long
// "Up" by the gyro and by the accelerometer, in one window and the next: what motion makes of it is
// 1.5 m/s^2 in the mean of half a second, and not three times in a row.
constexpr double kTiltWindow = 0.5;  // s
constexpr double kTiltApart = 0.15;  // rad
constexpr int kTiltsApart = 3;
// No base's track is wrong by more than a factor of 4; degrees are a factor of 57.
constexpr double kDegreesRatio = 10;
constexpr double kLeastTurn = 0.1;  // rad
constexpr int kOppositeTurns = 3;
constexpr int kFrozenValues = 50;

double SecondsBetween(Utime a, Utime b) {
  return std::abs((b - a).seconds());
}

}  // namespace

std::vector<DrDiagnosis> ImuCheck::Found() {
  return std::exchange(found_, {});
}

void ImuCheck::Report(DrDiagnosis diagnosis) {
  if (std::find(reported_.begin(), reported_.end(), diagnosis) != reported_.end()) return;
  reported_.push_back(diagnosis);
  found_.push_back(diagnosis);
}

void ImuCheck::Refuse(DrDiagnosis diagnosis) {
  usable_ = false;
  Report(diagnosis);
}

ImuCheck::Unit ImuCheck::UnitOf(double norm) {
  const auto within = [](double x) { return x >= kLeastGravity && x <= kMostGravity; };
  if (within(norm / kGravity)) return Unit::kMetric;
  if (within(norm)) return Unit::kG;
  return norm < kNoGravity ? Unit::kNoGravity : Unit::kUnknown;
}

void ImuCheck::JudgeUnit(const ImuSample& sample) {
  const double norm = sample.a_I_m_s2.norm();
  if (norm_ < 0 || !last_imu_) {
    norm_ = norm;
    unit_ = UnitOf(norm);
    other_unit_since_ = sample.utime;
  } else {
    const double dt = std::clamp((sample.utime - *last_imu_).seconds(), 0.0, 0.1);
    norm_ += std::min(1.0, dt / kUnitMemory) * (norm - norm_);
    // What a bump does to the mean is over when the mean is.
    if (UnitOf(norm_) == unit_) other_unit_since_ = sample.utime;
    if ((sample.utime - other_unit_since_).seconds() > kUnitMemory) unit_ = UnitOf(norm_);
  }
  if (unit_ == Unit::kG) Report(DrDiagnosis::kAccelInG);
  if (unit_ == Unit::kNoGravity) Report(DrDiagnosis::kAccelWithoutGravity);
  if (unit_ == Unit::kUnknown) Report(DrDiagnosis::kAccelInUnknownUnit);
}

void ImuCheck::JudgeStamps(const ImuSample& sample) {
  if (last_imu_ && sample.utime == *last_imu_ && repeats_.Add(sample.utime)) {
    Report(DrDiagnosis::kImuStampsRepeat);
  }
  same_values_ = sample.w_I_rad_s == last_gyro_ ? same_values_ + 1 : 0;
  last_gyro_ = sample.w_I_rad_s;
}

void ImuCheck::JudgeClock() {
  if (!last_imu_ || !last_wheel_ ||
      SecondsBetween(*last_imu_, *last_wheel_) <= kFarApart.seconds()) {
    apart_imu_ = apart_wheels_ = 0;
    apart_since_imu_.reset();
    apart_since_wheel_.reset();
    return;
  }
  if (!apart_since_imu_) apart_since_imu_ = last_imu_;
  if (!apart_since_wheel_) apart_since_wheel_ = last_wheel_;
  // Both live, each in its own time. One that is silent, or set back, is another matter.
  if (apart_imu_ >= kApartSamples && apart_wheels_ >= kApartSamples / 2 &&
      *last_imu_ - *apart_since_imu_ >= kApartFor &&
      *last_wheel_ - *apart_since_wheel_ >= kApartFor) {
    Refuse(DrDiagnosis::kImuOnAnotherClock);
  }
}

std::optional<ImuSample> ImuCheck::Take(const ImuSample& sample) {
  if (!usable_) return std::nullopt;
  JudgeStamps(sample);
  ImuSample out = sample;
  if (imu_.has_accel && sample.has_accel) {
    JudgeUnit(sample);
    out.has_accel = unit_ == Unit::kMetric || unit_ == Unit::kG;
    if (unit_ == Unit::kG) out.a_I_m_s2 *= kGravity;
    if (!out.has_accel) out.a_I_m_s2.setZero();
  }
  if (last_imu_ && sample.utime > *last_imu_) {
    const double dt = std::min((sample.utime - *last_imu_).seconds(), 0.1);
    gyro_turn_ += imu_.T_BI.rotation() * sample.w_I_rad_s * dt;
    gyro_s_ += dt;
    if (out.has_accel) JudgeTilt(sample, dt);
  }
  last_imu_ = sample.utime;
  ++apart_imu_;
  JudgeClock();
  if (!usable_) return std::nullopt;
  return out;
}

// What stands still in the world turns against the sensor by the gyro's rates.
void ImuCheck::JudgeTilt(const ImuSample& sample, double dt) {
  const Eigen::Quaterniond back = ExpSO3(-sample.w_I_rad_s * dt);
  up_ = back * up_ + sample.a_I_m_s2.normalized() * dt;
  up_before_ = back * up_before_;
  tilt_s_ += dt;
  if (tilt_s_ < kTiltWindow) return;
  const Eigen::Vector3d apart = up_before_.cross(up_);
  const bool one =
      up_before_.isZero() || std::atan2(apart.norm(), up_before_.dot(up_)) < kTiltApart;
  tilts_apart_ = one ? 0 : tilts_apart_ + 1;
  if (tilts_apart_ >= kTiltsApart) Refuse(DrDiagnosis::kGyroInDegrees);
  up_before_ = std::exchange(up_, Eigen::Vector3d::Zero());
  tilt_s_ = 0;
}

void ImuCheck::Take(const WheelSample& sample) {
  if (!usable_) return;
  last_wheel_ = sample.utime;
  ++apart_wheels_;
  JudgeClock();
  if (gyro_s_ > 0) {
    JudgeRest(sample);
    JudgeTurn(sample);
  }
  gyro_turn_.setZero();
  gyro_s_ = 0;
}

void ImuCheck::JudgeRest(const WheelSample& sample) {
  if (sample.dx_m != 0 || sample.dyaw_rad != 0 || sample.contact.wheel_drop) {
    rest_turn_.setZero();
    rest_s_ = 0;
    return;
  }
  rest_turn_ += gyro_turn_;
  rest_s_ += gyro_s_;
  // A robot that is carried or stands on a turntable turns back or stops; a full turn and more at
  // one rate is an offset.
  const double turn = std::abs(rest_turn_.z());
  if (rest_s_ > kDoubtFor) contradicts_wheels_ = rest_turn_.norm() > kMostRestRate * rest_s_;
  if (rest_s_ > kRestFor && turn > kMostRestRate * rest_s_ && turn > 2 * M_PI) {
    Refuse(DrDiagnosis::kGyroInDegrees);
  }
}

void ImuCheck::JudgeTurn(const WheelSample& sample) {
  ww_ += sample.dyaw_rad * sample.dyaw_rad;
  wg_ += sample.dyaw_rad * gyro_turn_.z();
  gg_ += gyro_turn_.z() * gyro_turn_.z();
  wheel_way_ += std::abs(sample.dyaw_rad);
  if (wheel_way_ < kLeastTurn) return;
  if (std::abs(wg_) > kDegreesRatio * ww_ && wg_ * wg_ > 0.5 * ww_ * gg_) {
    Refuse(DrDiagnosis::kGyroInDegrees);
  }
  if (same_values_ >= kFrozenValues && gg_ < 0.01 * ww_) Refuse(DrDiagnosis::kGyroFrozen);
  if (wg_ > ww_ / kMostYawScale && wg_ < ww_ * kMostYawScale) contradicts_wheels_ = false;
  const bool opposite = -wg_ > ww_ / kMostYawScale && -wg_ < ww_ * kMostYawScale;
  opposite_turns_ = opposite && wg_ * wg_ > 0.5 * ww_ * gg_ ? opposite_turns_ + 1 : 0;
  if (opposite_turns_ == kOppositeTurns) {
    wheels_turn_backwards_ = !wheels_turn_backwards_;
    Report(DrDiagnosis::kWheelsTurnBackwards);
  }
  // Each turn by itself.
  ww_ = wg_ = gg_ = wheel_way_ = 0;
}

}  // namespace gw::dr_ekf

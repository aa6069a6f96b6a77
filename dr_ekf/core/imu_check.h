// Checks that the IMU's numbers mean what the calibration says (unit, gravity, clock), by what
// needs no filter: gravity at any time, rates under still wheels, turns beside those of the wheels,
// stamps beside those of the wheels (docs/adr/0018-who-is-wrong.md).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "common/camera/calibration.h"
#include "common/contract/samples.h"
#include "common/core/time.h"
#include "dr_ekf/core/dr_diagnosis.h"
#include "dr_ekf/core/recurrence.h"

namespace gw::dr_ekf {

class ImuCheck {
 public:
  explicit ImuCheck(const ImuCalibration& imu) : imu_(imu) {}

  // The sample as it may be used: accelerations scaled or taken out. Empty: it is not to be used at
  // all. Samples carry camera time and are finite.
  std::optional<ImuSample> Take(const ImuSample& sample);
  // The wheels' sample, in camera time, as it arrives.
  void Take(const WheelSample& sample);

  // False: the stream was found to be useless, for good.
  bool usable() const { return usable_; }
  // The wheels stood while the gyro turned faster than the offset of any gyro: the robot is turned
  // by hand, or the gyro is wrong. Which of the two, what follows tells: until wheels and gyro have
  // been seen to agree, neither is a witness of motion.
  bool contradicts_wheels() const { return usable_ && contradicts_wheels_; }
  // The wheels turn the other way than the gyro, turn after turn: left and right are exchanged, or
  // both count backwards. Samples to be given to Take() then have their turn the right way round.
  bool wheels_turn_backwards() const { return wheels_turn_backwards_; }
  // What was found since the last call, each once.
  std::vector<DrDiagnosis> Found();

 private:
  enum class Unit { kUnknown, kMetric, kG, kNoGravity };
  static Unit UnitOf(double norm);

  void JudgeUnit(const ImuSample& sample);
  void JudgeStamps(const ImuSample& sample);
  void JudgeTilt(const ImuSample& sample, double dt);
  void JudgeClock();
  void JudgeRest(const WheelSample& sample);
  void JudgeTurn(const WheelSample& sample);
  void Report(DrDiagnosis diagnosis);
  void Refuse(DrDiagnosis diagnosis);

  ImuCalibration imu_;
  bool usable_ = true;
  bool contradicts_wheels_ = false;
  bool wheels_turn_backwards_ = false;
  std::vector<DrDiagnosis> found_;
  std::vector<DrDiagnosis> reported_;

  std::optional<Utime> last_imu_, last_wheel_;  // newest stamps
  Recurrence repeats_;                          // of a stamp
  int same_values_ = 0;                         // of the gyro, in a row
  Eigen::Vector3d last_gyro_ = Eigen::Vector3d::Zero();

  Unit unit_ = Unit::kUnknown;
  double norm_ = -1;  // m/s^2 (or g), mean over a second
  Utime other_unit_since_;

  // Both channels since their stamps are far apart.
  int apart_imu_ = 0, apart_wheels_ = 0;
  std::optional<Utime> apart_since_imu_, apart_since_wheel_;

  // Turns of the gyro under still wheels, and since the wheels' sample before; rad, axes of B.
  Eigen::Vector3d rest_turn_ = Eigen::Vector3d::Zero();
  double rest_s_ = 0;
  Eigen::Vector3d gyro_turn_ = Eigen::Vector3d::Zero();
  double gyro_s_ = 0;

  // "Up" in two windows of kTiltWindow in a row, both as the accelerometer measured it and carried
  // to the end of its window by the gyro; axes of I.
  Eigen::Vector3d up_ = Eigen::Vector3d::Zero(), up_before_ = Eigen::Vector3d::Zero();
  double tilt_s_ = 0;
  int tilts_apart_ = 0;  // windows in a row
  // Sums over wheel intervals in which something turned.
  double ww_ = 0, wg_ = 0, gg_ = 0;
  double wheel_way_ = 0;
  int opposite_turns_ = 0;  // in a row
};

}  // namespace gw::dr_ekf

// What the DR filter found wrong with its inputs, by name (docs/adr/0018-who-is-wrong.md).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <string_view>

namespace gw::dr_ekf {

enum class DrDiagnosis {
  kTimeWentBack,
  kTimeJumpedAhead,
  kImuOnAnotherClock,
  kImuStampsRepeat,
  kAccelInG,
  kAccelWithoutGravity,
  kAccelInUnknownUnit,
  kAccelUnfit,
  kGyroInDegrees,
  kGyroFrozen,
  kGyroBiasLarge,
  kImuNotNumbers,
  kWheelsNotNumbers,
  kWheelsTwice,
  kWheelsJumped,
  kWheelsTooFast,
  kHeadingStuck,
  kWheelTurnStuck,
  kWheelsStand,
  kWheelsContradicted,
  kTrackIsOther,
  kWheelsTurnBackwards,
  kParted,
};

struct DrDiagnosisWords {
  DrDiagnosis diagnosis;
  std::string_view name;  // short, for counters: dr.found.<name>
  // One plain English sentence for HEALTH: what is wrong, what was done, what to check.
  std::string_view text;
};

// In the order of the enumeration.
inline constexpr std::array kDiagnosisWords = {
    DrDiagnosisWords{DrDiagnosis::kTimeWentBack, "time_went_back",
                     "time went back: dead reckoning began anew; check who sets the clock"},
    DrDiagnosisWords{DrDiagnosis::kTimeJumpedAhead, "time_jumped_ahead",
                     "time jumped ahead: dead reckoning began anew; check who sets the clock"},
    DrDiagnosisWords{
        DrDiagnosis::kImuOnAnotherClock, "imu_on_another_clock",
        "the IMU's clock is not that of the wheels: the IMU is not used; check its stamps"},
    DrDiagnosisWords{
        DrDiagnosis::kImuStampsRepeat, "imu_stamps_repeat",
        "the IMU's samples repeat the stamp of the one before: not used; check its driver"},
    DrDiagnosisWords{DrDiagnosis::kAccelInG, "accel_in_g",
                     "the accelerometer gives g: scaled to m/s^2; check its driver"},
    DrDiagnosisWords{DrDiagnosis::kAccelWithoutGravity, "accel_without_gravity",
                     "the accelerometer gives no gravity: it is not used; check its driver"},
    DrDiagnosisWords{
        DrDiagnosis::kAccelInUnknownUnit, "accel_in_unknown_unit",
        "the accelerometer's gravity is not 9.8 m/s^2: it is not used; check unit and driver"},
    DrDiagnosisWords{DrDiagnosis::kAccelUnfit, "accel_unfit",
                     "the accelerometer contradicts the wheels at every change of speed: not used, "
                     "nor what it told before; check its filters and where it is mounted"},
    DrDiagnosisWords{
        DrDiagnosis::kGyroInDegrees, "gyro_in_degrees",
        "the gyro's rates are no rad/s (deg/s?): the IMU is not used; check its driver"},
    DrDiagnosisWords{DrDiagnosis::kGyroFrozen, "gyro_frozen",
                     "the gyro's values do not change while the wheels turn: the IMU is not used"},
    DrDiagnosisWords{
        DrDiagnosis::kGyroBiasLarge, "gyro_bias_large",
        "the gyro's bias is more than 3 deg/s: taken out; check the IMU's own calibration"},
    DrDiagnosisWords{
        DrDiagnosis::kImuNotNumbers, "imu_not_numbers",
        "the IMU's samples hold values that are no numbers: left out; check its driver"},
    DrDiagnosisWords{
        DrDiagnosis::kWheelsNotNumbers, "wheels_not_numbers",
        "the wheels' samples hold values that are no numbers: left out; check the base's driver"},
    DrDiagnosisWords{DrDiagnosis::kWheelsTwice, "wheels_twice",
                     "the wheels' samples come twice or overlap: the second ones are left out; "
                     "check for two senders (a second driver, a replay beside the robot)"},
    DrDiagnosisWords{DrDiagnosis::kWheelsJumped, "wheels_jumped",
                     "the wheels' sum jumped farther than any robot drives: that step is left out; "
                     "was the odometry reset?"},
    DrDiagnosisWords{DrDiagnosis::kWheelsTooFast, "wheels_too_fast",
                     "the wheels are again and again faster than any robot: such steps are left "
                     "out; check their unit (millimetres for metres?)"},
    DrDiagnosisWords{DrDiagnosis::kHeadingStuck, "heading_stuck",
                     "the base's heading does not change while its wheels turn: it is not used"},
    DrDiagnosisWords{DrDiagnosis::kWheelTurnStuck, "wheel_turn_stuck",
                     "the gyro turns and the wheels' heading does not: their turn is not used"},
    DrDiagnosisWords{DrDiagnosis::kWheelsStand, "wheels_stand",
                     "the wheels' reading stands still while the IMU feels motion: is the robot "
                     "carried, or are its encoders not heard? check the base's driver and cables"},
    DrDiagnosisWords{
        DrDiagnosis::kWheelsContradicted, "wheels_contradicted",
        "accelerometer and vision both contradict the wheels, and have for seconds: how far they "
        "go is left to the accelerometer; do they slip, is their scale right?"},
    DrDiagnosisWords{DrDiagnosis::kTrackIsOther, "track_is_other",
                     "the base turns by another factor than its track says (skid steer, wrong "
                     "track): estimated"},
    DrDiagnosisWords{
        DrDiagnosis::kWheelsTurnBackwards, "wheels_turn_backwards",
        "the wheels turn the other way than the gyro: their turn is reversed; check whether left "
        "and right are exchanged, or count backwards, and the IMU's axes"},
    DrDiagnosisWords{
        DrDiagnosis::kParted, "parted",
        "filter and wheels parted without slip: what contradicts the wheels is estimated anew"},
};
static_assert(kDiagnosisWords.size() == static_cast<size_t>(DrDiagnosis::kParted) + 1 &&
              std::ranges::adjacent_find(kDiagnosisWords, std::ranges::greater_equal{},
                                         &DrDiagnosisWords::diagnosis) == kDiagnosisWords.end());

constexpr std::string_view Text(DrDiagnosis diagnosis) {
  return kDiagnosisWords.at(static_cast<size_t>(diagnosis)).text;
}
constexpr std::string_view Name(DrDiagnosis diagnosis) {
  return kDiagnosisWords.at(static_cast<size_t>(diagnosis)).name;
}

}  // namespace gw::dr_ekf

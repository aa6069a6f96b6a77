// Is an IMU stream what dead reckoning takes it for? Gyro in rad/s, specific force in m/s^2, on the
// clock of the other sensors, in the axes that T_BI states. What a recording shows with certainty
// is converted, and said; what contradicts it is left out, and said; nothing is used in silence.
#pragma once

#include <string>
#include <vector>

#include "tools/data/import/recording.h"
#include "tools/data/import/streams.h"

namespace gw::importer {

enum class GyroUnit { kAuto, kRadPerS, kDegPerS };
enum class AccelUnit { kAuto, kMetrePerS2, kG };

struct ImuCheckOptions {
  GyroUnit gyro_unit = GyroUnit::kAuto;     // kAuto: decided by the data
  AccelUnit accel_unit = AccelUnit::kAuto;  // likewise
  double time_offset_s = 0;  // the IMU's stamps are ahead of the others' by this; taken off
};

// Checks and mends recording.imu; every finding is a warning of the recording:
// * clock: no common time with the wheels (else images, else ground truth), or turns that agree
// only
//   after a shift: the IMU is left out, and the offset named that --imu-time-offset takes;
// * gyro: turns against those of the wheels (else ground truth) tell deg/s from rad/s (57.3, where
//   wheels are wrong by a factor of 3 at most) and reversed or exchanged axes;
// * accelerometer: its norm in the quietest half-seconds tells g from m/s^2; near zero, gravity was
//   removed, and it is left out; so it is with gravity along no axis a robot may have.
void CheckImu(const ImuCheckOptions& options, Recording& recording);

// Puts IMU records in time order. Records that repeat a time are dropped and counted; when they are
// the most (a driver that stamps batches, lost digits) their times are not those of the
// measurements, and the stream is left out: empty afterwards, with a warning.
template <typename Sample>
void OrderImu(std::vector<Sample>& samples, const std::string& file,
              std::vector<std::string>& warnings) {
  const Result<Done> ordered = MakeOrdered(samples, file, warnings);
  if (ordered) return;
  samples.clear();
  warnings.push_back(ordered.error().message + "; the IMU is left out");
}

}  // namespace gw::importer

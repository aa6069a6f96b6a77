// The turns that a gyro tells against those that wheels or ground truth tell: they decide the
// gyro's unit, its axes and its clock.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/data/import/recording.h"

namespace gw::importer {

struct TurnWindow {
  Utime begin, end;
  Eigen::Vector3d turn_B = Eigen::Vector3d::Zero();  // rad; rotation vector of the body
};

// Who tells the turns, in windows of about half a second: long against the jitter of stamps, short
// against a turn.
struct TurnReference {
  std::string name;     // "wheels" or "ground truth"; empty: there is neither
  bool planar = false;  // wheels: of the turn only z is known
  std::vector<TurnWindow> windows;
  double turned_rad = 0;  // sum of the sizes
};
TurnReference MakeTurnReference(const Recording& recording);

// The gyro's integral over the windows as  scale * turn + bias * length  by least squares.
struct TurnFit {
  double scale = 0;        // 1: rad/s, 57.3: deg/s
  double correlation = 0;  // of both after removing the bias; -1 to 1
  double turned_rad = 0;   // of the reference, in the windows that the gyro covers
};

class TurnMatcher {
 public:
  // Both must outlive the matcher.
  TurnMatcher(const TurnReference& reference, const std::vector<ImuSample>& imu);

  // R_BI: the IMU's axes in the body. offset: t_imu = t_reference + offset. Empty when fewer than
  // ten windows are covered, or nothing turns in them.
  std::optional<TurnFit> Fit(const Eigen::Quaterniond& R_BI, DurationUs offset) const;

  // The offset within `around` +- 30 s where turns and gyro agree best, to 10 ms; empty when they
  // do nowhere (correlation below 0.9).
  std::optional<DurationUs> FindOffset(const Eigen::Quaterniond& R_BI, DurationUs around) const;

 private:
  std::optional<Eigen::Vector3d> Integral(Utime utime) const;

  const TurnReference& reference_;
  std::vector<Utime> times_;
  std::vector<Eigen::Vector3d> integral_;  // of the gyro from the first sample on, in its axes
};

}  // namespace gw::importer

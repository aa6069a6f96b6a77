#include "tools/lab/slam/dr_motion.h"

#include <algorithm>
#include <cmath>

namespace gw::tools {
namespace {

// Slower than any robot drives on purpose, faster than the rounding of a text file makes wheels.
constexpr double kStandingSpeed = 1e-3;    // m/s
constexpr double kStandingYawRate = 2e-3;  // rad/s
constexpr DurationUs kShortestStandstill = Milliseconds(500);
// Wheels or IMU say nothing for so long: nothing is known of the time between.
constexpr DurationUs kLargestGap = Milliseconds(500);

SE3 Increment(const WheelSample& sample) {
  return SE3(ExpSO3({0, 0, sample.dyaw_rad}), {sample.dx_m, sample.dy_m, 0});
}

double YawOf(const SE3& T) {
  const Eigen::Vector3d x = T.rotation() * Eigen::Vector3d::UnitX();
  return std::atan2(x.y(), x.x());
}

bool Stands(const WheelSample& sample) {
  const double dt = (sample.utime - sample.utime_begin).seconds();
  return dt > 0 && std::hypot(sample.dx_m, sample.dy_m) < kStandingSpeed * dt &&
         std::abs(sample.dyaw_rad) < kStandingYawRate * dt;
}

// Runs of a stream in which time increases, each with the wheel samples that the log holds before
// its end: in a log whose time goes back, they tell which of two runs of the same time is meant.
class Runs {
 public:
  // begins_anew(i): entry i does not go on from entry i - 1. wheels_before(i): as in DrOnlyRun.
  template <typename BeginsAnew, typename WheelsBefore>
  Runs(size_t size, const BeginsAnew& begins_anew, const WheelsBefore& wheels_before) {
    for (size_t i = 0; i < size; ++i) {
      if (i == 0 || begins_anew(i)) runs_.push_back({i, i, 0});
      runs_.back().end = i + 1;
      runs_.back().wheels_before_end = wheels_before(i);
    }
  }

  // What `read(begin, end)` makes of the first run that can still tell of wheel sample `index` and
  // gives a value; calls follow the log.
  template <typename Read>
  auto First(size_t index, const Read& read) -> decltype(read(size_t{}, size_t{})) {
    while (first_ < runs_.size() && runs_[first_].wheels_before_end <= index) ++first_;
    for (size_t i = first_; i < runs_.size(); ++i) {
      if (auto value = read(runs_[i].begin, runs_[i].end)) return value;
    }
    return std::nullopt;
  }

 private:
  struct Run {
    size_t begin, end;  // entries
    size_t wheels_before_end;
  };
  std::vector<Run> runs_;
  size_t first_ = 0;
};

// Entry of [begin, end) at or after the time, with the share of it between the entry before and it;
// empty outside, and in a gap.
struct Place {
  size_t after;
  double share;
};
template <typename Entry>
std::optional<Place> Find(const std::vector<Entry>& entries, size_t begin, size_t end,
                          Utime utime) {
  const auto first = entries.begin() + static_cast<std::ptrdiff_t>(begin);
  const auto last = entries.begin() + static_cast<std::ptrdiff_t>(end);
  const auto after = std::lower_bound(first, last, utime,
                                      [](const Entry& entry, Utime t) { return entry.utime < t; });
  if (after == last || (after == first && after->utime != utime)) return std::nullopt;
  const auto index = static_cast<size_t>(after - entries.begin());
  if (after->utime == utime) return Place{index, 1};
  const DurationUs gap = after->utime - std::prev(after)->utime;
  if (gap > kLargestGap) return std::nullopt;
  return Place{index, (utime - std::prev(after)->utime).seconds() / gap.seconds()};
}

class PoseTrack {
 public:
  explicit PoseTrack(const std::vector<DrPose>& poses)
      : poses_(poses),
        runs_(
            poses.size(),
            [&](size_t i) {
              return poses[i].utime <= poses[i - 1].utime ||
                     poses[i].reset_counter != poses[i - 1].reset_counter;
            },
            [&](size_t i) { return poses[i].wheels_before; }) {}

  // T_BaBb over the interval of wheel sample `index`, when one life of the filter covers both ends.
  std::optional<SE3> Motion(size_t index, Utime a, Utime b) {
    return runs_.First(index, [&](size_t begin, size_t end) -> std::optional<SE3> {
      const auto T_OBa = At(begin, end, a);
      const auto T_OBb = At(begin, end, b);
      if (!T_OBa || !T_OBb) return std::nullopt;
      return T_OBa->inverse() * *T_OBb;
    });
  }

 private:
  std::optional<SE3> At(size_t begin, size_t end, Utime utime) const {
    const auto place = Find(poses_, begin, end, utime);
    if (!place) return std::nullopt;
    if (place->share == 1) return poses_[place->after].T_OB;
    return Interpolate(poses_[place->after - 1].T_OB, poses_[place->after].T_OB, place->share);
  }

  const std::vector<DrPose>& poses_;
  Runs runs_;
};

// The gyro's integral about z of the body.
class GyroTrack {
 public:
  GyroTrack(const std::vector<GyroReading>& gyro, const ImuCalibration& calibration)
      : gyro_(gyro),
        offset_(DurationFromSeconds(calibration.time_offset_s)),
        runs_(
            gyro.size(), [&](size_t i) { return gyro[i].utime <= gyro[i - 1].utime; },
            [&](size_t i) { return gyro[i].wheels_before; }) {
    const Eigen::Vector3d z_I = calibration.T_BI.rotation().conjugate() * Eigen::Vector3d::UnitZ();
    double sum = 0;
    for (size_t i = 0; i < gyro.size(); ++i) {
      const double dt = i == 0 ? 0 : (gyro[i].utime - gyro[i - 1].utime).seconds();
      if (dt > 0) sum += 0.5 * dt * z_I.dot(gyro[i].w_I_rad_s + gyro[i - 1].w_I_rad_s);
      integral_.push_back(sum);
    }
  }

  // Turn over the interval (a, b] (camera time) of wheel sample `index`, bias included.
  std::optional<double> Turn(size_t index, Utime a, Utime b) {
    return runs_.First(index, [&](size_t begin, size_t end) -> std::optional<double> {
      const auto from = At(begin, end, a + offset_);
      const auto to = At(begin, end, b + offset_);
      if (!from || !to) return std::nullopt;
      return *to - *from;
    });
  }

 private:
  std::optional<double> At(size_t begin, size_t end, Utime utime) const {
    const auto place = Find(gyro_, begin, end, utime);
    if (!place) return std::nullopt;
    const double after = integral_[place->after];
    if (place->share == 1) return after;
    const double before = integral_[place->after - 1];
    return before + place->share * (after - before);
  }

  const std::vector<GyroReading>& gyro_;
  DurationUs offset_;
  Runs runs_;
  std::vector<double> integral_;
};

// One wheel interval as the three see it; empty: not covered.
struct Interval {
  double length_s = 0;
  std::optional<SE3> T_BaBb;
  std::optional<double> gyro_turn;  // bias included
};

std::vector<Interval> CoverIntervals(const DrOnlyRun& run, const Calibration& calibration) {
  const DurationUs offset = DurationFromSeconds(calibration.wheel.time_offset_s);
  PoseTrack poses(run.poses);
  GyroTrack gyro(run.gyro, calibration.imu);
  std::vector<Interval> out;
  for (size_t i = 0; i < run.wheels.size(); ++i) {
    const Utime a = run.wheels[i].utime_begin - offset;
    const Utime b = run.wheels[i].utime - offset;
    out.push_back({(b - a).seconds(), poses.Motion(i, a, b), gyro.Turn(i, a, b)});
  }
  return out;
}

std::vector<Standstill> FindStandstills(const std::vector<WheelSample>& wheels,
                                        const std::vector<Interval>& intervals) {
  std::vector<Standstill> out;
  Standstill open;
  double length_s = 0, turn = 0;
  const auto close = [&] {
    if (length_s >= kShortestStandstill.seconds()) {
      open.gyro_z_rad_s = turn / length_s;
      out.push_back(open);
    }
    length_s = turn = 0;
  };
  for (size_t i = 0; i < wheels.size(); ++i) {
    const bool stands = Stands(wheels[i]) && intervals[i].gyro_turn.has_value();
    const bool follows = i > 0 && wheels[i].utime_begin == wheels[i - 1].utime;
    if (!stands || !follows) close();
    if (!stands) continue;
    if (length_s == 0) open.first = i;
    open.last = i;
    length_s += intervals[i].length_s;
    turn += *intervals[i].gyro_turn;
  }
  close();
  return out;
}

// At wheel sample `index`. Precondition: not empty.
double BiasAt(const std::vector<Standstill>& standstills, size_t index) {
  const auto after = std::find_if(standstills.begin(), standstills.end(),
                                  [&](const Standstill& s) { return s.last >= index; });
  if (after == standstills.end()) return standstills.back().gyro_z_rad_s;
  if (after == standstills.begin() || after->first <= index) return after->gyro_z_rad_s;
  const auto before = std::prev(after);
  const double share =
      static_cast<double>(index - before->last) / static_cast<double>(after->first - before->last);
  return before->gyro_z_rad_s + share * (after->gyro_z_rad_s - before->gyro_z_rad_s);
}

GyroWitness AskGyro(const std::vector<WheelSample>& wheels,
                    const std::vector<Interval>& intervals) {
  GyroWitness gyro;
  gyro.standstills = FindStandstills(wheels, intervals);
  for (size_t i = 0; i < wheels.size(); ++i) {
    if (!intervals[i].T_BaBb || !intervals[i].gyro_turn) continue;
    const double bias = gyro.standstills.empty() ? 0 : BiasAt(gyro.standstills, i);
    gyro.turn_rad += *intervals[i].gyro_turn - bias * intervals[i].length_s;
    gyro.dr_turn_rad += YawOf(*intervals[i].T_BaBb);
    gyro.wheel_turn_rad += wheels[i].dyaw_rad;
    gyro.wheel_turned_rad += std::abs(wheels[i].dyaw_rad);
  }
  return gyro;
}

void MeasureShape(const std::vector<DrPose>& poses, DrMotion* motion) {
  if (poses.empty()) return;
  const double ground = poses.front().T_OB.translation().z();
  for (const DrPose& pose : poses) {
    const double height = pose.T_OB.translation().z() - ground;
    motion->height_min_m = std::min(motion->height_min_m, height);
    motion->height_max_m = std::max(motion->height_max_m, height);
    const double up = (pose.T_OB.rotation() * Eigen::Vector3d::UnitZ()).z();
    motion->tilt_max_rad = std::max(motion->tilt_max_rad, std::acos(std::clamp(up, -1.0, 1.0)));
  }
}

void MeasureStates(const std::vector<DrPose>& poses, DrMotion* motion) {
  for (size_t i = 1; i < poses.size(); ++i) {
    if (poses[i].reset_counter != poses[i - 1].reset_counter) continue;
    const SE3 T = poses[i - 1].T_OB.inverse() * poses[i].T_OB;
    motion->way_m += T.translation().norm();
    motion->turn_rad += YawOf(T);
  }
}

}  // namespace

WheelSum SumWheels(const std::vector<WheelSample>& wheels, DurationUs wheel_offset) {
  WheelSum sum;
  SE3 T_OB;
  for (size_t i = 0; i < wheels.size(); ++i) {
    const Utime begin = wheels[i].utime_begin - wheel_offset;
    if (i == 0) sum.poses.push_back({begin, T_OB});
    if (i > 0 && wheels[i].utime_begin != wheels[i - 1].utime) ++sum.gaps;
    T_OB = T_OB * Increment(wheels[i]);
    sum.poses.push_back({wheels[i].utime - wheel_offset, T_OB});
  }
  return sum;
}

DrMotion MeasureMotion(const DrOnlyRun& run, const Calibration& calibration) {
  DrMotion motion;
  MeasureShape(run.poses, &motion);
  if (run.wheels.empty()) {
    MeasureStates(run.poses, &motion);
    return motion;
  }
  const std::vector<Interval> intervals = CoverIntervals(run, calibration);
  double way = 0, turn = 0;
  for (size_t i = 0; i < run.wheels.size(); ++i) {
    const WheelSample& sample = run.wheels[i];
    DurationUs& covered = intervals[i].T_BaBb ? motion.covered : motion.uncovered;
    covered = covered + (sample.utime - sample.utime_begin);
    if (!intervals[i].T_BaBb) continue;
    motion.way_m += intervals[i].T_BaBb->translation().norm();
    motion.turn_rad += YawOf(*intervals[i].T_BaBb);
    way += std::hypot(sample.dx_m, sample.dy_m);
    turn += sample.dyaw_rad;
  }
  motion.wheel_way_m = way;
  motion.wheel_turn_rad = turn;
  if (!run.gyro.empty()) motion.gyro = AskGyro(run.wheels, intervals);
  return motion;
}

std::vector<SlipSpan> SlipSpans(const std::vector<DrPose>& poses) {
  std::vector<SlipSpan> spans;
  bool open = false;
  for (const DrPose& pose : poses) {
    if (pose.slip && (!open || pose.utime < spans.back().end)) {
      spans.push_back({pose.utime, pose.utime});
    } else if (pose.slip) {
      spans.back().end = pose.utime;
    }
    open = pose.slip;
  }
  return spans;
}

}  // namespace gw::tools

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

// The states in runs without a reset and without a step back of time.
class Lives {
 public:
  explicit Lives(const std::vector<DrPose>& poses) : poses_(poses) {
    for (size_t i = 0; i < poses.size(); ++i) {
      const bool continues = i > 0 && poses[i].utime > poses[i - 1].utime &&
                             poses[i].reset_counter == poses[i - 1].reset_counter;
      if (!continues) begins_.push_back(i);
    }
    begins_.push_back(poses.size());
  }

  // T_BaBb when one life covers both instants. Calls follow the log: `anew` says that its time went
  // back since the call before, so that an earlier life is over.
  std::optional<SE3> Motion(Utime a, Utime b, bool anew) {
    if (anew) ++life_;
    for (size_t life = life_; life + 1 < begins_.size(); ++life) {
      const auto T_OBa = PoseAt(life, a);
      const auto T_OBb = PoseAt(life, b);
      if (!T_OBa || !T_OBb) continue;
      life_ = life;
      return T_OBa->inverse() * *T_OBb;
    }
    return std::nullopt;
  }

 private:
  std::optional<SE3> PoseAt(size_t life, Utime utime) const {
    const auto begin = poses_.begin() + static_cast<std::ptrdiff_t>(begins_[life]);
    const auto end = poses_.begin() + static_cast<std::ptrdiff_t>(begins_[life + 1]);
    const auto b = std::lower_bound(begin, end, utime,
                                    [](const DrPose& pose, Utime t) { return pose.utime < t; });
    if (b == end) return std::nullopt;
    if (b->utime == utime) return b->T_OB;
    if (b == begin) return std::nullopt;
    const auto a = std::prev(b);
    if (b->utime - a->utime > kLargestGap) return std::nullopt;
    const double share = (utime - a->utime).seconds() / (b->utime - a->utime).seconds();
    return Interpolate(a->T_OB, b->T_OB, share);
  }

  const std::vector<DrPose>& poses_;
  std::vector<size_t> begins_;  // of each life, and the end of the last
  size_t life_ = 0;
};

// Gyro about z of the body, in camera time, in the order of the log.
class GyroTurn {
 public:
  GyroTurn(const std::vector<ImuSample>& imu, const ImuCalibration& calibration) {
    const DurationUs offset = DurationFromSeconds(calibration.time_offset_s);
    const Eigen::Vector3d z_I = calibration.T_BI.rotation().conjugate() * Eigen::Vector3d::UnitZ();
    for (const ImuSample& sample : imu) {
      rates_.push_back({sample.utime - offset, z_I.dot(sample.w_I_rad_s)});
    }
  }
  bool empty() const { return rates_.empty(); }

  // Mean over [begin, end]; empty with fewer than three samples.
  std::optional<double> Mean(Utime begin, Utime end) const {
    double sum = 0;
    int count = 0;
    for (auto it = FirstAt(begin); it != rates_.end() && it->utime <= end; ++it, ++count) {
      if (it->utime < begin) break;  // time went back
      sum += it->rate;
    }
    return count < 3 ? std::nullopt : std::optional(sum / count);
  }

  double Integral(const std::vector<Standstill>& standstills) const {
    double turn = 0;
    for (size_t i = 1; i < rates_.size(); ++i) {
      const DurationUs dt = rates_[i].utime - rates_[i - 1].utime;
      if (dt.us <= 0 || dt > kLargestGap) continue;
      const double rate = (rates_[i].rate + rates_[i - 1].rate) / 2;
      turn += (rate - Bias(standstills, rates_[i].utime)) * dt.seconds();
    }
    return turn;
  }

 private:
  struct Rate {
    Utime utime;
    double rate;
  };
  std::vector<Rate>::const_iterator FirstAt(Utime utime) const {
    return std::lower_bound(rates_.begin(), rates_.end(), utime,
                            [](const Rate& rate, Utime t) { return rate.utime < t; });
  }
  static double Bias(const std::vector<Standstill>& standstills, Utime utime) {
    if (standstills.empty()) return 0;
    const auto middle = [](const Standstill& s) {
      return s.begin.us + (s.end.us - s.begin.us) / 2;
    };
    const auto after = std::find_if(standstills.begin(), standstills.end(),
                                    [&](const Standstill& s) { return middle(s) >= utime.us; });
    if (after == standstills.end()) return standstills.back().gyro_z_rad_s;
    if (after == standstills.begin()) return after->gyro_z_rad_s;
    const auto before = std::prev(after);
    const auto span = static_cast<double>(std::max<int64_t>(middle(*after) - middle(*before), 1));
    const double share = static_cast<double>(utime.us - middle(*before)) / span;
    return before->gyro_z_rad_s + share * (after->gyro_z_rad_s - before->gyro_z_rad_s);
  }

  std::vector<Rate> rates_;
};

std::vector<Standstill> FindStandstills(const std::vector<WheelSample>& wheels, DurationUs offset,
                                        const GyroTurn& gyro) {
  std::vector<Standstill> out;
  std::optional<Standstill> open;
  const auto close = [&] {
    if (open && open->end - open->begin >= kShortestStandstill) {
      if (const auto bias = gyro.Mean(open->begin, open->end)) {
        open->gyro_z_rad_s = *bias;
        out.push_back(*open);
      }
    }
    open.reset();
  };
  for (const WheelSample& sample : wheels) {
    const Utime begin = sample.utime_begin - offset;
    if (open && begin != open->end) close();
    if (!Stands(sample)) {
      close();
      continue;
    }
    if (!open) open = Standstill{begin, begin};
    open->end = sample.utime - offset;
  }
  close();
  return out;
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
  const DurationUs offset = DurationFromSeconds(calibration.wheel.time_offset_s);
  const GyroTurn gyro(run.imu, calibration.imu);
  MeasureShape(run.poses, &motion);
  if (!gyro.empty()) {
    motion.standstills = FindStandstills(run.wheels, offset, gyro);
    motion.gyro_turn_rad = gyro.Integral(motion.standstills);
  }
  if (run.wheels.empty()) {
    MeasureStates(run.poses, &motion);
    return motion;
  }
  Lives lives(run.poses);
  double way = 0, turn = 0, turned = 0;
  for (size_t i = 0; i < run.wheels.size(); ++i) {
    const WheelSample& sample = run.wheels[i];
    const DurationUs length = sample.utime - sample.utime_begin;
    const bool anew = i > 0 && sample.utime <= run.wheels[i - 1].utime;
    const auto T = lives.Motion(sample.utime_begin - offset, sample.utime - offset, anew);
    (T ? motion.covered : motion.uncovered) = (T ? motion.covered : motion.uncovered) + length;
    if (!T) continue;
    motion.way_m += T->translation().norm();
    motion.turn_rad += YawOf(*T);
    way += std::hypot(sample.dx_m, sample.dy_m);
    turn += sample.dyaw_rad;
    turned += std::abs(sample.dyaw_rad);
  }
  motion.wheel_way_m = way;
  motion.wheel_turn_rad = turn;
  motion.wheel_turned_rad = turned;
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

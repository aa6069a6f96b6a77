#include "tools/lab/check/motion_sources.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/core/median.h"

namespace gw::check {
namespace {

constexpr DurationUs kWheelStep = Milliseconds(100);
// Between two images: more than a hole of some images is no step.
constexpr DurationUs kLongestStep = Milliseconds(350);

void AddGyro(const std::vector<ImuSample>& imu, const SE3& T_BI, MotionSources& motion) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < imu.size(); ++i) {
    if (i > 0) {
      const double dt = (imu[i].utime - imu[i - 1].utime).seconds();
      if (dt <= 0) continue;
      sum += T_BI.rotation() * (0.5 * dt * (imu[i].w_I_rad_s + imu[i - 1].w_I_rad_s));
    }
    for (int axis = 0; axis < 3; ++axis) {
      motion.gyro_B[static_cast<size_t>(axis)].Add(imu[i].utime, sum[axis]);
    }
  }
}

void AddWheels(const std::vector<WheelSample>& wheels, MotionSources& motion) {
  double turn = 0, way = 0, open_turn = 0;
  std::optional<Utime> open;
  for (const WheelSample& sample : wheels) {
    motion.wheel_turn.Add(sample.utime_begin, turn);
    motion.wheel_way.Add(sample.utime_begin, way);
    if (!open) open = sample.utime_begin;
    turn += sample.dyaw_rad;
    way += sample.dx_m;
    open_turn += sample.dyaw_rad;
    motion.wheel_turn.Add(sample.utime, turn);
    motion.wheel_way.Add(sample.utime, way);
    if (sample.utime - *open < kWheelStep) continue;
    if (sample.utime - *open < kLongestStep) {
      motion.wheel_turns.push_back({*open, sample.utime, open_turn});
    }
    open.reset();
    open_turn = 0;
  }
}

// Median, and its standard deviation: that of the values by their median absolute deviation
// (1.4826 for a normal distribution), times sqrt(pi / 2n).
std::pair<double, double> MedianAndSigma(std::vector<double> values) {
  const double median = MedianOf(&values);
  for (double& value : values) value = std::abs(value - median);
  return {median, kSigmaOverMedian * MedianOf(&values) * std::sqrt(M_PI / 2 / std::ssize(values))};
}

// Directions are unit vectors in the body, ahead and back alike.
void AddDirection(const std::vector<Eigen::Vector3d>& directions, MotionSources& motion) {
  if (directions.size() < 2) return;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& d : directions) scatter += d * d.transpose();
  const Eigen::Vector3d axis =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(2);
  const double sign = axis.x() < 0 ? -1 : 1;
  const double axis_yaw = std::atan2(sign * axis.y(), sign * axis.x());
  std::vector<double> yaws, pitches;
  for (const Eigen::Vector3d& d : directions) {
    const Eigen::Vector3d ahead = d.dot(axis) * sign < 0 ? -d : d;
    yaws.push_back(std::remainder(std::atan2(ahead.y(), ahead.x()) - axis_yaw, 2 * M_PI));
    pitches.push_back(std::atan2(ahead.z(), ahead.head<2>().norm()));
  }
  const auto [yaw, yaw_sigma] = MedianAndSigma(std::move(yaws));
  const auto [pitch, pitch_sigma] = MedianAndSigma(std::move(pitches));
  motion.straight_yaw_rad = axis_yaw + yaw;
  motion.straight_pitch_rad = pitch;
  motion.straight_sigma_rad = std::max(yaw_sigma, pitch_sigma);
}

void AddVision(const VisionRun& vision, MotionSources& motion) {
  constexpr double kStraightTurn = 0.02;  // rad a step
  std::vector<Eigen::Vector3d> directions;
  for (size_t i = 1; i < vision.poses.size(); ++i) {
    const VisionPose& a = vision.poses[i - 1];
    const VisionPose& b = vision.poses[i];
    if (!a.seen || !b.seen || b.utime - a.utime > kLongestStep || b.utime <= a.utime) continue;
    const SE3 T_AB = a.T_WB.inverse() * b.T_WB;
    const double turn = LogSO3(T_AB.rotation()).z();
    motion.vision_turns.push_back({a.utime, b.utime, turn});
    motion.vision_ways.push_back({a.utime, b.utime, T_AB.translation().x()});
    const double way = T_AB.translation().norm();
    if (std::abs(turn) > kStraightTurn || way < 0.01) continue;
    motion.straight_m += way;
    directions.emplace_back(T_AB.translation() / way);
  }
  AddDirection(directions, motion);
}

}  // namespace

std::optional<double> MotionSources::Turned(Utime t) const {
  if (!gyro_B[2].empty()) return gyro_B[2].At(t);
  return wheel_turn.At(t);
}

MotionSources MakeMotionSources(const std::vector<ImuSample>& imu,
                                const std::vector<WheelSample>& wheels, const VisionRun* vision,
                                const Calibration& calibration) {
  MotionSources motion;
  AddGyro(imu, calibration.imu.T_BI, motion);
  AddWheels(wheels, motion);
  if (vision != nullptr) AddVision(*vision, motion);
  return motion;
}

}  // namespace gw::check

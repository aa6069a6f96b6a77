#include "tools/sim/sim/recorded_motion.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

namespace gw::sim {
namespace {

constexpr double kKnotSpacing = 0.1;  // s
constexpr double kSmoothing = 0.07;   // s, least sigma of the average around a knot
// The reference is believed in the mean over a way, sigma in m: a laser's pose is off by
// centimetres from one to the next, wheels are not within so little. A turn counts as the way of a
// wheel half a track from the middle, m per rad.
constexpr double kReferenceMean = 0.25;
constexpr double kTurnWay = 0.3;
constexpr double kMountWindow = 1.5;  // s, of a motion from which the mount is found
constexpr double kMountNoise = 0.03;  // m, of such a motion: half of it is good by wheels and laser
constexpr double kMaxOdometryGap = 5.0;  // s
constexpr double kMaxBridge = 5.0;       // m by odometry between two poses of the reference

using Curve = std::vector<Eigen::Vector3d>;  // x, y, unwrapped yaw at every knot

struct Sample {
  double t = 0;
  SE3 pose;
};

enum class Disorder { kError, kLeaveOut };

// Where an error is.
std::string LineOf(const std::string& path, int number) {
  return path + ":" + std::to_string(number) + ": ";
}

// disorder: what becomes of a pose that is not later than the one before.
Result<std::vector<Sample>> LoadPoses(const std::string& path, Disorder disorder) {
  std::ifstream in(path);
  if (!in) return Error{ErrorCode::kNotFound, path + ": cannot open the trajectory"};
  std::vector<Sample> out;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    std::istringstream fields(line);
    double v[8];
    bool good = true;
    for (double& value : v) good = good && (fields >> value) && std::isfinite(value);
    const Eigen::Quaterniond q =
        good ? Eigen::Quaterniond(v[7], v[4], v[5], v[6]) : Eigen::Quaterniond::Identity();
    if (!good || std::abs(q.norm() - 1) > 1e-2) {
      return Error{ErrorCode::kBadData,
                   LineOf(path, number) + "want `t x y z qx qy qz qw`, got `" + line + "`"};
    }
    if (!out.empty() && v[0] <= out.back().t) {
      if (disorder == Disorder::kLeaveOut) continue;
      return Error{ErrorCode::kBadData, LineOf(path, number) + "time does not grow"};
    }
    out.push_back({v[0], SE3(q, {v[1], v[2], v[3]})});
  }
  if (out.size() < 2) return Error{ErrorCode::kBadData, path + ": holds no trajectory"};
  return out;
}

double YawOf(const SE3& T) {
  const Eigen::Vector3d x = T.rotation() * Eigen::Vector3d::UnitX();
  return std::atan2(x.y(), x.x());
}

Curve PlanarOf(const std::vector<Sample>& samples) {
  Curve out;
  double yaw = YawOf(samples.front().pose);
  for (const Sample& s : samples) {
    yaw += std::remainder(YawOf(s.pose) - yaw, 2 * std::numbers::pi);
    out.emplace_back(s.pose.translation().x(), s.pose.translation().y(), yaw);
  }
  return out;
}

// Knots from one before `begin` on; each is the value at its instant of a line that is fitted to
// the samples around it with Gaussian weights of this sigma (s).
Curve FitKnots(const std::vector<Sample>& samples, double begin, int count, double sigma) {
  const Curve planar = PlanarOf(samples);
  Curve out;
  size_t first = 0;
  for (int k = 0; k < count; ++k) {
    const double t = begin + (k - 1) * kKnotSpacing;
    while (first + 2 < samples.size() && samples[first + 1].t < t - 4 * sigma) ++first;
    double w0 = 0, w1 = 0, w2 = 0;
    Eigen::Vector3d v0 = Eigen::Vector3d::Zero(), v1 = Eigen::Vector3d::Zero();
    for (size_t i = first; i < samples.size(); ++i) {
      const double dt = samples[i].t - t;
      if (dt > 4 * sigma && i > first + 1) break;
      const double w = std::exp(-0.5 * dt * dt / (sigma * sigma)) + 1e-6;
      w0 += w;
      w1 += w * dt;
      w2 += w * dt * dt;
      v0 += w * planar[i];
      v1 += w * dt * planar[i];
    }
    const double determinant = w0 * w2 - w1 * w1;
    out.push_back(determinant > 1e-12 ? Eigen::Vector3d((w2 * v0 - w1 * v1) / determinant)
                                      : Eigen::Vector3d(v0 / w0));
  }
  return out;
}

// A uniform cubic B-spline with the knots as control points: second derivative continuous. x: in
// knots, from the second on, not negative.
Eigen::Vector3d SplineAt(const Curve& knots, double x) {
  const auto i = std::min(static_cast<size_t>(x), knots.size() - 4);
  const double f = x - static_cast<double>(i);
  const double b0 = (1 - f) * (1 - f) * (1 - f) / 6;
  const double b1 = (3 * f * f * f - 6 * f * f + 4) / 6;
  const double b2 = (-3 * f * f * f + 3 * f * f + 3 * f + 1) / 6;
  const double b3 = f * f * f / 6;
  return b0 * knots[i] + b1 * knots[i + 1] + b2 * knots[i + 2] + b3 * knots[i + 3];
}

// Between the knots as far as `x`, in knots from the second on; beyond the ends as between the last
// two.
Eigen::Vector3d LineAt(const Curve& knots, double x) {
  const double first = std::clamp(std::floor(x + 1), 0.0, static_cast<double>(knots.size() - 2));
  const auto i = static_cast<size_t>(first);
  return knots[i] + (x + 1 - first) * (knots[i + 1] - knots[i]);
}

// `pose` moved on by what the odometry did between two of its poses.
Eigen::Vector3d Carry(const Eigen::Vector3d& pose, const Eigen::Vector3d& odometry_then,
                      const Eigen::Vector3d& odometry_now) {
  const double turn = pose.z() - odometry_then.z();
  Eigen::Vector3d out;
  out << pose.head<2>() +
             Eigen::Rotation2Dd(turn) * (odometry_now.head<2>() - odometry_then.head<2>()),
      odometry_now.z() + turn;
  return out;
}

// Where the frame of the odometry is in the frame of the reference. A reference follows a laser or
// a marker, or what its maker took for the middle of the robot: centimetres from the wheels' axle,
// and degrees beside where they roll.
struct Mount {
  double yaw = 0;
  Eigen::Vector2d lever = Eigen::Vector2d::Zero();  // m
};

// By least squares over motions of both, with Cauchy's weights:
//   way of the reference = s R(yaw) way of the odometry + (I - R(turn)) lever
// with a free scale s of the wheels, which stays theirs.
Mount FindMount(const std::vector<Sample>& reference, double begin, const Curve& odometry) {
  const Curve planar = PlanarOf(reference);
  std::vector<Eigen::Matrix<double, 2, 4>> rows;
  std::vector<Eigen::Vector2d> ways;
  size_t j = 0;
  for (size_t i = 0; i < reference.size(); ++i) {
    while (j + 1 < reference.size() && reference[j].t < reference[i].t + kMountWindow) ++j;
    const double window = reference[j].t - reference[i].t;
    if (window < kMountWindow || window > 3 * kMountWindow) continue;
    const Eigen::Vector3d from = LineAt(odometry, (reference[i].t - begin) / kKnotSpacing);
    const Eigen::Vector3d to = LineAt(odometry, (reference[j].t - begin) / kKnotSpacing);
    const Eigen::Vector2d way = Eigen::Rotation2Dd(-from.z()) * (to - from).head<2>();
    const Eigen::Matrix2d turned = Eigen::Rotation2Dd(to.z() - from.z()).toRotationMatrix();
    Eigen::Matrix<double, 2, 4> row;
    row << way.x(), -way.y(), 1 - turned(0, 0), -turned(0, 1),  //
        way.y(), way.x(), -turned(1, 0), 1 - turned(1, 1);
    rows.push_back(row);
    ways.push_back(Eigen::Rotation2Dd(-planar[i].z()) * (planar[j] - planar[i]).head<2>());
  }
  Eigen::Vector4d x(1, 0, 0, 0);
  for (int round = 0; round < 10; ++round) {
    // Without turns the lever is not seen and stays where it is said to be.
    Eigen::Matrix4d H = Eigen::Vector4d(0, 0, 1, 1).asDiagonal();
    Eigen::Vector4d g = Eigen::Vector4d::Zero();
    for (size_t k = 0; k < rows.size(); ++k) {
      const double r2 = (ways[k] - rows[k] * x).squaredNorm() / (kMountNoise * kMountNoise);
      H += rows[k].transpose() * rows[k] / (1 + r2);
      g += rows[k].transpose() * ways[k] / (1 + r2);
    }
    const Eigen::LDLT<Eigen::Matrix4d> factor(H);
    if (!factor.isPositive() || H(0, 0) < 1e-3) return {};  // stands
    x = factor.solve(g);
  }
  return {std::atan2(x[1], x[0]), x.tail<2>()};
}

// How far the odometry has moved by each knot, m. A robot that stands by its wheels stands.
std::vector<double> Effort(const Curve& odometry) {
  std::vector<double> out = {0};
  for (size_t k = 1; k < odometry.size(); ++k) {
    const Eigen::Vector3d step = odometry[k] - odometry[k - 1];
    out.push_back(out.back() + step.head<2>().norm() + kTurnWay * std::abs(step.z()));
  }
  return out;
}

// The reference at every knot: between two of its poses the odometry carries both towards each
// other, and what they differ by goes with the time between them. `odometry`: the knots of its own
// curve.
Curve BridgeReference(const std::vector<Sample>& reference, const Mount& mount, double begin,
                      const Curve& odometry) {
  Curve planar = PlanarOf(reference);
  for (Eigen::Vector3d& pose : planar) {
    pose.head<2>() += Eigen::Rotation2Dd(pose.z()) * mount.lever;
    pose.z() += mount.yaw;
  }
  const auto odometry_at = [&](double t) { return LineAt(odometry, (t - begin) / kKnotSpacing); };
  Curve out;
  size_t before = 0;
  for (size_t k = 0; k < odometry.size(); ++k) {
    const double t = begin + (static_cast<double>(k) - 1) * kKnotSpacing;
    while (before + 2 < reference.size() && reference[before + 1].t <= t) ++before;
    const Sample& a = reference[before];
    const Sample& b = reference[before + 1];
    const Eigen::Vector3d now = odometry_at(t);
    const double s = std::clamp((t - a.t) / (b.t - a.t), 0.0, 1.0);
    out.push_back((1 - s) * Carry(planar[before], odometry_at(a.t), now) +
                  s * Carry(planar[before + 1], odometry_at(b.t), now));
  }
  return out;
}

// The mean of what the poses around each knot, by the way of the odometry, say of it.
Curve MeanByOdometry(const Curve& poses, const Curve& odometry) {
  const std::vector<double> effort = Effort(odometry);
  Curve out;
  size_t first = 0;
  for (size_t k = 0; k < poses.size(); ++k) {
    while (effort[k] - effort[first] > 3 * kReferenceMean) ++first;
    double weight = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (size_t j = first; j < poses.size() && effort[j] - effort[k] <= 3 * kReferenceMean; ++j) {
      const double way = (effort[j] - effort[k]) / kReferenceMean;
      const double w = std::exp(-0.5 * way * way);
      weight += w;
      sum += w * Carry(poses[j], odometry[j], odometry[k]);
    }
    out.push_back(sum / weight);
  }
  return out;
}

// The wheels, or the way between two poses of the reference, must not be unknown for too long.
Result<Done> CheckGaps(const std::vector<Sample>& reference, const std::string& trajectory,
                       const std::vector<Sample>& wheels, const std::string& odometry) {
  for (size_t i = 1; i < wheels.size(); ++i) {
    const double gap = wheels[i].t - wheels[i - 1].t;
    if (gap <= kMaxOdometryGap) continue;
    return Error{ErrorCode::kBadData, odometry + ": gap of " + std::to_string(gap) + " s after " +
                                          std::to_string(wheels[i - 1].t) +
                                          " s, cut the recording there"};
  }
  size_t w = 1;
  while (w < wheels.size() && wheels[w].t <= reference.front().t) ++w;
  for (size_t i = 1; i < reference.size(); ++i) {
    double way = 0;
    for (; w < wheels.size() && wheels[w].t <= reference[i].t; ++w) {
      way += (wheels[w].pose.translation() - wheels[w - 1].pose.translation()).norm();
    }
    if (way <= kMaxBridge) continue;
    return Error{ErrorCode::kBadData, trajectory + ": no pose for " + std::to_string(way) +
                                          " m after " + std::to_string(reference[i - 1].t) +
                                          " s, cut the recording there"};
  }
  return Done{};
}

}  // namespace

Result<RecordedMotion> RecordedMotion::Load(const std::string& trajectory,
                                            const std::string& odometry) {
  auto reference = LoadPoses(trajectory, Disorder::kLeaveOut);
  if (!reference) return reference.error();
  const auto wheels = LoadPoses(odometry, Disorder::kError);
  if (!wheels) return wheels.error();
  std::erase_if(*reference,
                [&](const Sample& s) { return s.t < wheels->front().t || s.t > wheels->back().t; });
  if (reference->size() < 2 || reference->back().t - reference->front().t < 1.0) {
    return Error{ErrorCode::kBadData, odometry + ": shares less than a second with " + trajectory};
  }
  const double begin = reference->front().t;
  const double end = reference->back().t;
  const auto whole = CheckGaps(*reference, trajectory, *wheels, odometry);
  if (!whole) return whole.error();
  RecordedMotion motion;
  motion.duration_s_ = end - begin;
  motion.reference_interval_s_ = (end - begin) / static_cast<double>(reference->size() - 1);
  // One knot before the begin and two after the end. Wheels whose samples come apart or in bursts
  // are smoothed over one of their intervals.
  const int knots = static_cast<int>(motion.duration_s_ / kKnotSpacing) + 4;
  const double interval =
      (wheels->back().t - wheels->front().t) / static_cast<double>(wheels->size() - 1);
  const Curve by_wheels = FitKnots(*wheels, begin, knots, std::max(kSmoothing, interval));
  const Mount mount = FindMount(*reference, begin, by_wheels);
  motion.knots_ = MeanByOdometry(BridgeReference(*reference, mount, begin, by_wheels), by_wheels);
  for (const Sample& s : *wheels) {
    if (s.t >= begin && s.t <= end) motion.odometry_.push_back({s.t - begin, s.pose});
  }
  return motion;
}

RecordedMotion::Planar RecordedMotion::At(double t) const {
  const Eigen::Vector3d v = SplineAt(knots_, std::clamp(t, 0.0, duration_s_) / kKnotSpacing);
  return {v.head<2>(), std::remainder(v.z(), 2 * std::numbers::pi)};
}

double RecordedMotion::odometry_rate_hz() const {
  const double span = odometry_.back().t - odometry_.front().t;
  return span > 0 ? static_cast<double>(odometry_.size() - 1) / span : 20;
}

floorplan::FloorMap RecordedMotion::CorridorAround(double half_width) const {
  const double margin = half_width + 1.5;
  Eigen::AlignedBox2d bounds;
  for (double t = 0; t <= duration_s_; t += kKnotSpacing) bounds.extend(At(t).position);
  floorplan::FloorMap map;
  map.resolution = 0.1;
  map.origin = bounds.min() - Eigen::Vector2d(margin, margin);
  map.width = static_cast<int>((bounds.sizes().x() + 2 * margin) / map.resolution) + 1;
  map.height = static_cast<int>((bounds.sizes().y() + 2 * margin) / map.resolution) + 1;
  map.occupied.assign(static_cast<size_t>(map.width) * map.height, 0);
  floorplan::FloorMap way = map;
  for (double t = 0; t <= duration_s_; t += kKnotSpacing / 2) {
    const Eigen::Vector2i cell = way.CellOf(At(t).position);
    way.occupied[way.index(cell.x(), cell.y())] = 1;
  }
  const std::vector<float> distance = floorplan::DistanceToOccupied(way, margin);
  for (size_t i = 0; i < distance.size(); ++i) {
    map.occupied[i] = distance[i] > half_width && distance[i] < half_width + 0.4 ? 1 : 0;
  }
  return map;
}

}  // namespace gw::sim

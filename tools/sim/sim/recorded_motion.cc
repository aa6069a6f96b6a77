#include "tools/sim/sim/recorded_motion.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

namespace gw::sim {
namespace {

constexpr double kKnotSpacing = 0.1;  // s
constexpr double kSmoothing = 0.07;   // s, sigma of the average around a knot
constexpr double kMaxGap = 1.0;       // s

struct Stamped {
  double t = 0;
  SE3 pose;
};

Result<std::vector<Stamped>> LoadPoses(const std::string& path) {
  std::ifstream in(path);
  if (!in) return Error{ErrorCode::kNotFound, path + ": cannot open the trajectory"};
  std::vector<Stamped> out;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    std::istringstream fields(line);
    double v[8];
    bool good = true;
    for (double& value : v) good = good && (fields >> value) && std::isfinite(value);
    const std::string where = path + ":" + std::to_string(number) + ": ";
    const Eigen::Quaterniond q =
        good ? Eigen::Quaterniond(v[7], v[4], v[5], v[6]) : Eigen::Quaterniond::Identity();
    if (!good || std::abs(q.norm() - 1) > 1e-2) {
      return Error{ErrorCode::kBadData, where + "want `t x y z qx qy qz qw`, got `" + line + "`"};
    }
    if (!out.empty() && v[0] <= out.back().t) {
      return Error{ErrorCode::kBadData, where + "time does not grow"};
    }
    if (!out.empty() && v[0] - out.back().t > kMaxGap) {
      return Error{ErrorCode::kBadData, where + "gap of " + std::to_string(v[0] - out.back().t) +
                                            " s, cut the recording there"};
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

}  // namespace

Result<RecordedMotion> RecordedMotion::Load(const std::string& trajectory,
                                            const std::string& odometry) {
  const auto truth = LoadPoses(trajectory);
  if (!truth) return truth.error();
  const auto wheels = LoadPoses(odometry);
  if (!wheels) return wheels.error();
  const double begin = std::max(truth->front().t, wheels->front().t);
  const double end = std::min(truth->back().t, wheels->back().t);
  if (end - begin < 1.0) {
    return Error{ErrorCode::kBadData, odometry + ": shares less than a second with " + trajectory};
  }
  RecordedMotion motion;
  motion.duration_s_ = end - begin;
  std::vector<Eigen::Vector3d> planar;  // x, y, unwrapped yaw
  double yaw = YawOf(truth->front().pose);
  for (const Stamped& s : *truth) {
    yaw += std::remainder(YawOf(s.pose) - yaw, 2 * std::numbers::pi);
    planar.emplace_back(s.pose.translation().x(), s.pose.translation().y(), yaw);
  }
  // Every knot is the value of a line fitted around it; the spline through knots as control points
  // smooths a little more. One knot before the begin and two after the end.
  const int knots = static_cast<int>(motion.duration_s_ / kKnotSpacing) + 4;
  size_t first = 0;
  for (int k = 0; k < knots; ++k) {
    const double t = begin + (k - 1) * kKnotSpacing;
    while (first + 2 < truth->size() && (*truth)[first + 1].t < t - 4 * kSmoothing) ++first;
    double w0 = 0, w1 = 0, w2 = 0;
    Eigen::Vector3d v0 = Eigen::Vector3d::Zero(), v1 = Eigen::Vector3d::Zero();
    for (size_t i = first; i < truth->size(); ++i) {
      const double dt = (*truth)[i].t - t;
      if (dt > 4 * kSmoothing && i > first + 1) break;
      const double w = std::exp(-0.5 * dt * dt / (kSmoothing * kSmoothing)) + 1e-6;
      w0 += w;
      w1 += w * dt;
      w2 += w * dt * dt;
      v0 += w * planar[i];
      v1 += w * dt * planar[i];
    }
    const double determinant = w0 * w2 - w1 * w1;
    motion.knots_.push_back(determinant > 1e-12 ? Eigen::Vector3d((w2 * v0 - w1 * v1) / determinant)
                                                : Eigen::Vector3d(v0 / w0));
  }
  for (const Stamped& s : *wheels) {
    if (s.t >= begin && s.t <= end) motion.odometry_.push_back({s.t - begin, s.pose});
  }
  return motion;
}

RecordedMotion::Planar RecordedMotion::At(double t) const {
  const double x = std::clamp(t, 0.0, duration_s_) / kKnotSpacing;
  const auto i = std::min(static_cast<size_t>(x), knots_.size() - 4);
  const double f = x - static_cast<double>(i);
  // Uniform cubic B-spline: second derivative continuous.
  const double b0 = (1 - f) * (1 - f) * (1 - f) / 6;
  const double b1 = (3 * f * f * f - 6 * f * f + 4) / 6;
  const double b2 = (-3 * f * f * f + 3 * f * f + 3 * f + 1) / 6;
  const double b3 = f * f * f / 6;
  const Eigen::Vector3d v =
      b0 * knots_[i] + b1 * knots_[i + 1] + b2 * knots_[i + 2] + b3 * knots_[i + 3];
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

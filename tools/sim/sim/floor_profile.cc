#include "tools/sim/sim/floor_profile.h"

#include <cmath>

#include "common/core/random.h"

namespace gw::sim {
namespace {

constexpr double kCell = 1.2;           // m; at most one bump in each square of this side
constexpr double kBumpShare = 0.3;      // of the squares have one
constexpr double kWaveHeight = 0.0004;  // m
constexpr double kWaveLength = 0.5;     // m
constexpr double kHalfWheelbase = 0.1;  // m, between axle and casters
constexpr double kHalfTrack = 0.115;    // m

}  // namespace

double FloorProfile::Height(const Eigen::Vector2d& p) const {
  if (roughness_ <= 0) return 0;
  constexpr double kTau = 6.283185307179586;
  double h = kWaveHeight *
             (std::sin(kTau * p.x() / kWaveLength) * std::sin(kTau * p.y() / (1.3 * kWaveLength)) +
              std::sin(kTau * (p.x() + 0.7 * p.y()) / (2.3 * kWaveLength)));
  const int cx = static_cast<int>(std::floor(p.x() / kCell));
  const int cy = static_cast<int>(std::floor(p.y() / kCell));
  for (int y = cy - 1; y <= cy + 1; ++y) {
    for (int x = cx - 1; x <= cx + 1; ++x) {
      const uint64_t key =
          static_cast<uint64_t>(x + 100000) << 32 | static_cast<uint64_t>(y + 100000);
      CounterRng rng(seed_, 0xB0B, key);
      if (rng.Uniform() > kBumpShare) continue;
      const Eigen::Vector2d centre((x + rng.Uniform()) * kCell, (y + rng.Uniform()) * kCell);
      const double radius = rng.Uniform(0.06, 0.12);
      const double height = rng.Uniform(0.0008, 0.003);
      h += height * std::exp(-0.5 * (p - centre).squaredNorm() / (radius * radius));
    }
  }
  return roughness_ * h;
}

SE3 FloorProfile::BodyPose(const Eigen::Vector2d& p, double yaw) const {
  const Eigen::Vector2d x(std::cos(yaw), std::sin(yaw));
  const Eigen::Vector2d y(-x.y(), x.x());
  const double front = Height(p + kHalfWheelbase * x), back = Height(p - kHalfWheelbase * x);
  const double left = Height(p + kHalfTrack * y), right = Height(p - kHalfTrack * y);
  const double pitch = -std::atan2(front - back, 2 * kHalfWheelbase);  // nose up is negative
  const double roll = std::atan2(left - right, 2 * kHalfTrack);
  const Eigen::Quaterniond q = ExpSO3({0, 0, yaw}) * ExpSO3({0, pitch, 0}) * ExpSO3({roll, 0, 0});
  return SE3(q, {p.x(), p.y(), 0.5 * (left + right)});
}

}  // namespace gw::sim

#include "tools/sim/sim/base.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/sim/sim/part_tolerance.h"

namespace gw::sim {
namespace {

constexpr double kSlipLength = 0.3;  // m over which slip is alike

}  // namespace

Base::Base(const BaseConfig& config, const floorplan::FloorMap& obstacles,
           const std::vector<float>& distance, uint64_t seed)
    : config_(config),
      obstacles_(obstacles),
      distance_(distance),
      slip_noise_(seed, 0x511, kSlipLength),
      heading_noise_(seed, 0x4EAD, kSlipLength) {
  CounterRng rng(seed, 0xBA5E, 0);
  const double scale = DrawError(&rng, config.scale_error);
  const double difference = DrawError(&rng, config.wheel_difference);
  left_scale_ = 1 + scale - difference / 2;
  right_scale_ = 1 + scale + difference / 2;
  track_ = config.track_m * (1 + DrawError(&rng, config.track_error));
}

void Base::Command(double time_s, double v, double w) {
  commands_.push_back({time_s + config_.dead_time_s, std::clamp(v, -config_.max_v, config_.max_v),
                       std::clamp(w, -config_.max_w, config_.max_w)});
}

void Base::Step(double time_s, double dt, const Disturbance& disturbance) {
  while (!commands_.empty() && commands_.front().time_s <= time_s) {
    wanted_v_ = commands_.front().v;
    wanted_w_ = commands_.front().w;
    commands_.pop_front();
  }
  const auto follow = [&](double* speed, double wanted) {
    const double change = (wanted - *speed) * std::min(1.0, dt / config_.lag_s);
    const double limit = config_.max_wheel_accel * dt;
    *speed += std::clamp(change, -limit, limit);
  };
  follow(&left_v_, wanted_v_ - wanted_w_ * config_.track_m / 2);
  follow(&right_v_, wanted_v_ + wanted_w_ * config_.track_m / 2);
  left_way_ += left_v_ * dt;
  right_way_ += right_v_ * dt;

  const double left = left_v_ * left_scale_ * disturbance.traction;
  const double right = right_v_ * right_scale_ * disturbance.traction;
  double v = 0.5 * (left + right);
  // Turning on the spot also is a way for the tyres.
  const double tyre_speed = 0.5 * (std::abs(left) + std::abs(right));
  way_ += tyre_speed * dt;
  // A ratio that is constant over kSlipLength adds up to sigma * sqrt(way).
  const double noise =
      (disturbance.on_carpet ? config_.carpet_factor : 1.0) / std::sqrt(kSlipLength);
  v *= 1 + noise * config_.slip_per_sqrt_m * slip_noise_.At(way_);
  const double heading_rate = noise * config_.heading_deg_per_sqrt_m * std::numbers::pi / 180 *
                              heading_noise_.At(way_) * tyre_speed;
  const double w = (right - left) / track_ + heading_rate + disturbance.push_w;
  const double middle = yaw_ + 0.5 * w * dt;
  const Eigen::Vector2d forward(std::cos(middle), std::sin(middle));
  const Eigen::Vector2d sideways(-forward.y(), forward.x());
  const Eigen::Vector2d next =
      position_ + dt * ((v + disturbance.push_v.x()) * forward + disturbance.push_v.y() * sideways);
  const double distance = floorplan::DistanceAt(obstacles_, distance_, next);
  bumper_ = distance < config_.radius_m;
  // In contact the wheels turn on, but the body moves only away from the obstacle.
  if (!bumper_ || distance > floorplan::DistanceAt(obstacles_, distance_, position_))
    position_ = next;
  yaw_ = std::remainder(yaw_ + w * dt, 2 * std::numbers::pi);
}

}  // namespace gw::sim

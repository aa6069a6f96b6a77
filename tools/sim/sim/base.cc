#include "tools/sim/sim/base.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/sim/sim/part_tolerance.h"

namespace gw::sim {
namespace {

constexpr double kSlipLength = 0.3;  // m over which slip is alike
constexpr double kSlipTurn = 0.3;    // rad, likewise

}  // namespace

Base::Base(const BaseConfig& config, const floorplan::FloorMap& obstacles,
           const std::vector<float>& distance, uint64_t seed)
    : config_(config),
      obstacles_(obstacles),
      distance_(distance),
      slip_noise_(seed, 0x511, kSlipLength),
      heading_noise_(seed, 0x4EAD, kSlipLength),
      sideways_noise_(seed, 0x51DE, kSlipLength),
      turn_noise_(seed, 0x7042, kSlipTurn) {
  CounterRng rng(seed, 0xBA5E, 0);
  const double scale = DrawError(&rng, config.scale_error);
  const double difference = DrawError(&rng, config.wheel_difference);
  left_scale_ = 1 + scale - difference / 2;
  right_scale_ = 1 + scale + difference / 2;
  track_ = config.track_m * config.track_factor * (1 + DrawError(&rng, config.track_error));
  turn_centre_ = DrawError(&rng, config.turn_centre_m);
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
  // Its controller knows how far the base turns, if its odometry does not.
  const double half_track = 0.5 * config_.track_m * config_.track_factor;
  follow(&left_v_, wanted_v_ - wanted_w_ * half_track);
  follow(&right_v_, wanted_v_ + wanted_w_ * half_track);
  left_way_ += left_v_ * dt;
  right_way_ += right_v_ * dt;

  const Motion motion = Roll(dt, disturbance);
  const double w = motion.w + disturbance.push_w;
  const double middle = yaw_ + 0.5 * w * dt;
  const Eigen::Vector2d forward(std::cos(middle), std::sin(middle));
  const Eigen::Vector2d sideways(-forward.y(), forward.x());
  const Eigen::Vector2d next =
      position_ + dt * ((motion.v + disturbance.push_v.x()) * forward +
                        (motion.sideways + disturbance.push_v.y()) * sideways);
  const double distance = floorplan::DistanceAt(obstacles_, distance_, next);
  bumper_ = distance < config_.radius_m;
  // In contact the wheels turn on, but the body moves only away from the obstacle.
  if (!bumper_ || distance > floorplan::DistanceAt(obstacles_, distance_, position_))
    position_ = next;
  yaw_ = std::remainder(yaw_ + w * dt, 2 * std::numbers::pi);
}

Base::Motion Base::Roll(double dt, const Disturbance& disturbance) {
  const double left = left_v_ * left_scale_ * disturbance.traction;
  const double right = right_v_ * right_scale_ * disturbance.traction;
  Motion motion;
  motion.v = 0.5 * (left + right);
  // Turning on the spot also is a way for the tyres.
  const double tyre_speed = 0.5 * (std::abs(left) + std::abs(right));
  way_ += tyre_speed * dt;
  // A ratio that is constant over kSlipLength adds up to sigma * sqrt(way).
  const double noise =
      (disturbance.on_carpet ? config_.carpet_factor : 1.0) / std::sqrt(kSlipLength);
  motion.v *= 1 + noise * config_.slip_per_sqrt_m * slip_noise_.At(way_);
  const double rad = std::numbers::pi / 180;
  const double turn_rate = (right - left) / track_;
  turn_ += std::abs(turn_rate) * dt;
  const double turn_error = config_.turn_deg_per_sqrt_rad * rad / std::sqrt(kSlipTurn);
  motion.w = turn_rate * (1 + turn_error * turn_noise_.At(turn_)) +
             noise * config_.heading_deg_per_sqrt_m * rad * heading_noise_.At(way_) * tyre_speed;
  motion.sideways = -config_.side_slip * motion.v * motion.v * motion.w - turn_centre_ * motion.w +
                    noise * config_.sideways_per_sqrt_m * sideways_noise_.At(way_) * tyre_speed;
  return motion;
}

}  // namespace gw::sim

#include "tools/sim/sim/odometry_resampler.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/core/random.h"

namespace gw::sim {

OdometryResampler::OdometryResampler(const OdometryConfig& config, Utime start, uint64_t seed)
    : config_(config), start_(start), seed_(seed), last_stamp_(start) {}

Utime OdometryResampler::NextTurn() const {
  // Late by less than half a period, so that turns keep their order.
  CounterRng rng(seed_, 0x0D0, static_cast<uint64_t>(turn_));
  const double late =
      std::min(std::abs(rng.Normal()) * config_.stamp_jitter_ms * 1e-3, 0.45 / config_.rate_hz);
  return start_ + DurationFromSeconds(static_cast<double>(turn_ + 1) / config_.rate_hz + late);
}

void OdometryResampler::Push(const WheelSample& packet) {
  if (config_.rate_hz <= 0) {
    packet_ = packet;
    return;
  }
  driven_ = driven_ * SE3(ExpSO3({0, 0, packet.dyaw_rad}), {packet.dx_m, packet.dy_m, 0});
  contact_.bumper |= packet.contact.bumper;
}

std::optional<WheelSample> OdometryResampler::Take(Utime now) {
  const DurationUs delay = DurationFromSeconds(config_.delay_s);
  if (config_.rate_hz <= 0) {
    std::optional<WheelSample> out = std::exchange(packet_, std::nullopt);
    if (out) {
      out->utime = out->utime + delay;
      out->utime_begin = out->utime_begin + delay;
    }
    return out;
  }
  const Utime turn = NextTurn();
  if (now < turn) return std::nullopt;
  WheelSample out;
  out.utime = turn + delay;
  out.utime_begin = last_stamp_ + delay;
  out.seq = turn_;
  out.dx_m = driven_.translation().x();
  out.dy_m = driven_.translation().y();
  out.dyaw_rad = LogSO3(driven_.rotation()).z();
  out.contact = contact_;
  ++turn_;
  last_stamp_ = turn;
  driven_ = SE3();
  contact_ = {};
  return out;
}

}  // namespace gw::sim

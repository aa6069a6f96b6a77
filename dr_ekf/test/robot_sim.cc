#include "dr_ekf/test/robot_sim.h"

#include <algorithm>
#include <cmath>

#include "common/core/random.h"
#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kStep = 1e-3;  // s

// White noise through three first-order lags: smooth enough to be sampled at 100 Hz, and with the
// same power at low frequency as one lag of (sigma, tau).
class SmoothNoise {
 public:
  SmoothNoise(double sigma, double tau) : sigma_(sigma), tau_(tau) {}
  void Advance(double dt, CounterRng& rng) {
    const double k = dt / tau_;
    x_[0] += -x_[0] * k + sigma_ * std::sqrt(2 * k) * rng.Normal();
    x_[1] += (x_[0] - x_[1]) * k;
    x_[2] += (x_[1] - x_[2]) * k;
  }
  double value() const { return x_[2]; }

 private:
  double sigma_, tau_;
  double x_[3] = {0, 0, 0};
};

struct Motion {
  SE3 T_GB;
  Vector3d v_B = Vector3d::Zero();
  double dway = 0, dyaw = 0;  // of this step, as the wheels roll it
};

// How much of a slip there is at an instant, 0 to 1.
double Strength(const SlipSpan& slip, double t) {
  if (t < slip.begin_s || t >= slip.end_s) return 0;
  if (slip.ramp_s <= 0) return 1;
  return std::min({1.0, (t - slip.begin_s) / slip.ramp_s, (slip.end_s - t) / slip.ramp_s});
}

// A threshold under the axle, as the wheels' radius rounds it.
constexpr double kBumpLength = 0.3;   // m
constexpr double kBumpHeight = 0.01;  // m

double Toward(double from, double to, double step) {
  return from + std::clamp(to - from, -step, step);
}

std::vector<Motion> Drive(const DrEkfConfig& config, const SimOptions& options, bool rough) {
  CounterRng rng(options.seed, 1, 0);
  const int steps = static_cast<int>(std::lround(options.duration_s / kStep));
  std::vector<Motion> out(steps + 1);
  const double side_tau = 0.05;
  const double side_sigma = 1 / std::sqrt(2 * side_tau);  // white of density 1 at low frequency
  SmoothNoise side(side_sigma, side_tau), up(side_sigma, side_tau);
  SmoothNoise roll(options.floor_tilt, 0.5), pitch(options.floor_tilt, 0.5);
  double v_goal = 0, w_goal = 0, v_ramp = 0, w_ramp = 0, v1 = 0, w1 = 0, v = 0, w = 0;
  double yaw = 0;
  double next_change = options.parked_s;
  CounterRng bump_rng(options.seed, 4, 0);
  double next_bump = options.parked_s;
  double bump_at = -1, driven = 0;  // m
  Vector3d p = Vector3d::Zero();
  for (int i = 1; i <= steps; ++i) {
    const double t = i * kStep;
    if (options.drive && t >= next_change) {
      next_change = t + rng.Uniform(1.0, 3.0);
      const bool stop = options.stops && rng.Uniform() < 0.2;
      v_goal = stop ? 0 : rng.Uniform(0.2, options.max_speed);
      w_goal = stop ? 0 : rng.Uniform(-options.max_turn, options.max_turn);
    }
    v_ramp = Toward(v_ramp, v_goal, options.acceleration * kStep);
    w_ramp = Toward(w_ramp, w_goal, 2.0 * kStep);
    v1 += (v_ramp - v1) * kStep / 0.05;
    w1 += (w_ramp - w1) * kStep / 0.05;
    v += (v1 - v) * kStep / 0.05;
    w += (w1 - w) * kStep / 0.05;
    if (v_goal == 0 && w_goal == 0 && std::abs(v) < 1e-5 && std::abs(w) < 1e-5) {
      v = w = v1 = w1 = v_ramp = w_ramp = 0;
    }
    // White per way, so that a resting robot does not slide.
    const double slide = config.lateral_sigma_m_per_sqrt_m * std::sqrt(std::abs(v));
    if (slide > 0) {
      side.Advance(kStep, rng);
      up.Advance(kStep, rng);
    }
    double ground_v = v, push_y = 0, push_w = 0;
    for (const SlipSpan& slip : options.slips) {
      ground_v *= 1 + (slip.traction - 1) * Strength(slip, t);
      push_y += slip.push_y * Strength(slip, t);
      push_w += slip.push_w * Strength(slip, t);
    }
    const double way = ground_v * kStep;
    driven += std::abs(way);
    if (options.bumps_per_minute > 0 && t >= next_bump && driven > bump_at + kBumpLength) {
      next_bump = t + bump_rng.Uniform(0.5, 1.5) * 60 / options.bumps_per_minute;
      bump_at = driven;
    }
    // The floor rises and falls like sin^4: it lifts the axle, and with the castor behind it tilts
    // the body by a third of its slope.
    double climb = 0, bump_pitch = 0;  // m/s, rad
    if (rough && driven > bump_at && driven < bump_at + kBumpLength) {
      const double phase = M_PI * (driven - bump_at) / kBumpLength;
      const double slope =
          kBumpHeight * 4 * std::pow(std::sin(phase), 3) * std::cos(phase) * M_PI / kBumpLength;
      climb = slope * std::abs(ground_v);
      bump_pitch = -slope / 3;
    }
    const Quaterniond q_before = out[i - 1].T_GB.rotation();
    yaw += (w + push_w) * kStep;
    const Quaterniond q =
        Eigen::AngleAxisd(yaw, Vector3d::UnitZ()) *
        Eigen::AngleAxisd(rough ? pitch.value() + bump_pitch : 0, Vector3d::UnitY()) *
        Eigen::AngleAxisd(rough ? roll.value() : 0, Vector3d::UnitX());
    const Vector3d v_B(
        ground_v, slide * side.value() + options.crab * ground_v - w * options.turn_centre + push_y,
        rough ? slide * up.value() + climb : 0);
    p += q_before.slerp(0.5, q) * v_B * kStep;
    out[i].T_GB = SE3(q, p);
    out[i].v_B = v_B;
    out[i].dway = v * kStep;
    out[i].dyaw = w * kStep;
  }
  return out;
}

}  // namespace

const SE3& Recording::TruthAt(Utime utime) const {
  const int64_t i = (utime - begin).us / 1000;
  return T_GB[static_cast<size_t>(
      std::clamp<int64_t>(i, 0, static_cast<int64_t>(T_GB.size()) - 1))];
}

Calibration WheelsOnly() {
  Calibration c;
  c.wheel.present = true;
  c.wheel.rate_hz = 50;
  return c;
}

Calibration WheelsAndGyro() {
  Calibration c = WheelsOnly();
  c.imu.present = true;
  c.imu.has_accel = false;
  c.imu.rate_hz = 100;
  // Kobuki's gyro is turned about z (drivers/kobuki/README.md).
  c.imu.T_BI = SE3(Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ())), {0, 0, 0});
  return c;
}

Calibration WheelsAndImu() {
  Calibration c = WheelsAndGyro();
  c.imu.has_accel = true;
  // As in a camera: x right, y down, z forward.
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  c.imu.T_BI = SE3(Quaterniond(R), {0.15, 0.02, 0.3});
  return c;
}

Recording Simulate(const Calibration& calibration, const DrEkfConfig& config,
                   const SimOptions& options) {
  const ImuCalibration& imu = calibration.imu;
  const WheelCalibration& wheel = calibration.wheel;
  const bool rough = imu.present && imu.has_accel;
  const std::vector<Motion> motion = Drive(config, options, rough);
  Recording out;
  out.calibration = calibration;
  out.begin = {1'000'000'000};
  for (const Motion& m : motion) {
    out.T_GB.push_back(m.T_GB);
    out.speed.push_back(m.v_B.x());
  }
  struct Arrival {
    Utime utime;
    Sample sample;
  };
  std::vector<Arrival> arrivals;
  const int last = static_cast<int>(motion.size()) - 1;
  const auto time = [&](int i) { return out.begin + Milliseconds(i); };

  if (imu.present) {
    CounterRng rng(options.seed, 2, 0);
    const int every = static_cast<int>(std::lround(1000 / imu.rate_hz));
    const Eigen::Matrix3d R_IB = imu.T_BI.rotation().conjugate().toRotationMatrix();
    const Vector3d arm = imu.T_BI.translation();
    Vector3d bias_g = options.gyro_bias, bias_a = options.accel_bias;
    const double root_rate = std::sqrt(imu.rate_hz);
    const auto rate_B = [&](int i) {  // over the step that ends at i
      return Vector3d(
          LogSO3(motion[i - 1].T_GB.rotation().conjugate() * motion[i].T_GB.rotation()) / kStep);
    };
    const auto p_GI = [&](int i) { return motion[i].T_GB * arm; };
    int64_t seq = 0;
    for (int i = every; i + 2 <= last; i += every) {
      for (int k = 0; k < 3; ++k) {
        bias_g[k] += imu.gyro_walk / root_rate * rng.Normal();
        bias_a[k] += imu.accel_walk / root_rate * rng.Normal();
      }
      const double t = i * kStep;
      Vector3d step = Vector3d::Zero();
      if (options.gyro_step_at_s >= 0 && t >= options.gyro_step_at_s) step.z() = options.gyro_step;
      ImuSample s;
      s.utime = time(i) + DurationFromSeconds(imu.time_offset_s);
      s.seq = ++seq;
      const Vector3d w_B = 0.5 * (rate_B(i) + rate_B(i + 1)) + step;
      s.w_I_rad_s = options.gyro_scale.cwiseInverse().cwiseProduct(R_IB * w_B) + bias_g;
      for (int k = 0; k < 3; ++k) s.w_I_rad_s[k] += imu.gyro_noise * root_rate * rng.Normal();
      if (imu.has_accel) {
        s.has_accel = true;
        // Second difference over +-2 ms of the true way of the IMU.
        const Vector3d a_G = (p_GI(i + 2) - 2 * p_GI(i) + p_GI(i - 2)) / (4 * kStep * kStep);
        const Vector3d f_B =
            motion[i].T_GB.rotation().conjugate() * (a_G + Vector3d(0, 0, kGravity));
        s.a_I_m_s2 = R_IB * f_B + bias_a;
        for (int k = 0; k < 3; ++k) s.a_I_m_s2[k] += imu.accel_noise * root_rate * rng.Normal();
      }
      arrivals.push_back({time(i), s});
    }
  }

  if (wheel.present) {
    CounterRng rng(options.seed, 3, 0);
    const int every = static_cast<int>(std::lround(1000 / wheel.rate_hz));
    double way = 0, yaw = 0, heading = 0;
    int64_t left_before = 0, right_before = 0;
    int64_t seq = 0;
    for (int i = 1; i <= last; ++i) {
      const Motion& m = motion[i];
      const double dway = m.dway / options.true_scale;
      const double dyaw = (m.dyaw - options.turn_per_way * m.dway) / options.true_yaw_scale;
      way += dway + options.wheel_noise * config.wheel_sigma_m_per_sqrt_m *
                        std::sqrt(std::abs(dway)) * rng.Normal();
      yaw += dyaw +
             options.wheel_noise * kRadPerDeg *
                 (config.wheel_sigma_deg_per_sqrt_m * std::sqrt(std::abs(dway)) * rng.Normal() +
                  config.wheel_sigma_deg_per_sqrt_rad * std::sqrt(std::abs(dyaw)) * rng.Normal());
      heading += m.dyaw;
      if (m.dway != 0 || m.dyaw != 0) {
        heading += kHeadingSigmaPerSqrtS * std::sqrt(kStep) * rng.Normal();
      }
      for (const SlipSpan& slip : options.slips) {
        const double strength = Strength(slip, i * kStep);
        way += strength * (slip.extra_v * kStep + (slip.spin - 1) * dway);
        yaw += strength * slip.extra_w * kStep;
      }
      if (i % every != 0) continue;
      const double half = 0.5 * wheel.track_width_m * yaw;
      const auto left = static_cast<int64_t>(std::floor((way - half) * wheel.ticks_per_metre));
      const auto right = static_cast<int64_t>(std::floor((way + half) * wheel.ticks_per_metre));
      const double dl = static_cast<double>(left - left_before) / wheel.ticks_per_metre;
      const double dr = static_cast<double>(right - right_before) / wheel.ticks_per_metre;
      left_before = left;
      right_before = right;
      WheelSample s;
      s.utime = time(i) + DurationFromSeconds(wheel.time_offset_s);
      s.utime_begin = time(i - every) + DurationFromSeconds(wheel.time_offset_s);
      s.seq = ++seq;
      s.has_ticks = true;
      s.left_ticks = static_cast<uint16_t>(left);
      s.right_ticks = static_cast<uint16_t>(right);
      const double d = 0.5 * (dl + dr);
      s.dyaw_rad = (dr - dl) / wheel.track_width_m;
      s.dx_m = d * std::cos(0.5 * s.dyaw_rad);
      s.dy_m = d * std::sin(0.5 * s.dyaw_rad);
      s.has_heading = options.with_heading;
      if (options.with_heading) {
        s.heading_rad = std::remainder(std::round(heading / kHeadingStep) * kHeadingStep, 2 * M_PI);
      }
      arrivals.push_back({time(i) + DurationFromSeconds(options.wheel_delay_s), s});
    }
  }
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.utime < b.utime; });
  for (const Arrival& a : arrivals) out.samples.push_back(a.sample);
  return out;
}

DrFilter::Output Feed(DrFilter& filter, const Sample& sample) {
  return std::visit([&](const auto& s) { return filter.Push(s); }, sample);
}

std::vector<DrState> FeedAll(DrFilter& filter, const std::vector<Sample>& samples) {
  std::vector<DrState> out;
  for (const Sample& sample : samples) {
    for (DrState& state : Feed(filter, sample).states) out.push_back(std::move(state));
  }
  return out;
}

}  // namespace gw::dr_ekf

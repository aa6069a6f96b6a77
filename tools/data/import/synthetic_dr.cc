#include "tools/data/import/synthetic_dr.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>

#include "common/core/random.h"
#include "tools/data/files/format.h"
#include "tools/data/import/trajectory.h"

namespace gw::importer {
namespace {

constexpr double kRadPerDeg = 0.017453292519943295;
constexpr double kFrameRateHz = 30.0;  // of the "per frame" sigmas
constexpr uint64_t kNoiseStream = 0x5D2A01;
constexpr uint64_t kBiasStream = 0x5D2A02;

using Matrix12d = Eigen::Matrix<double, 12, 12>;

Error BadOption(const std::string& item, const std::string& rule) {
  return {ErrorCode::kInvalidArgument, "--dr-from-groundtruth: '" + item + "': " + rule};
}

// Standard normal numbers, scaled per axis.
Vector6d Draw(uint64_t seed, uint64_t stream, uint64_t index, double scale_t, double scale_r) {
  CounterRng rng(seed, stream, index);
  Vector6d out;
  for (int i = 0; i < 6; ++i) out[i] = rng.Normal() * (i < 3 ? scale_t : scale_r);
  return out;
}

Matrix6d Diagonal(double variance_t, double variance_r) {
  Vector6d d;
  d << variance_t, variance_t, variance_t, variance_r, variance_r, variance_r;
  return d.asDiagonal();
}

double Square(double x) {
  return x * x;
}

}  // namespace

Result<SyntheticDrOptions> ParseSyntheticDr(const std::string& text) {
  SyntheticDrOptions options;
  std::set<std::string> seen;
  std::stringstream items(text);
  for (std::string item; std::getline(items, item, ',');) {
    const size_t equals = item.find('=');
    if (equals == std::string::npos) return BadOption(item, "expected key=value");
    const std::string key = item.substr(0, equals);
    if (!seen.insert(key).second) return BadOption(item, "given twice");
    const char* const end = item.data() + item.size();
    const char* unit = item.data() + equals + 1;
    if (key == "seed") {
      const auto [next, status] = std::from_chars(unit, end, options.seed);
      if (status != std::errc() || next != end) return BadOption(item, "expected a whole number");
      continue;
    }
    double value = 0;
    const auto [next, status] = std::from_chars(unit, end, value);
    if (status != std::errc() || !std::isfinite(value) || value < 0) {
      return BadOption(item, "expected a number that is not negative");
    }
    const std::string suffix(next, end);
    double* const rotation = key == "sigma_r"  ? &options.sigma_r_rad
                             : key == "bias_r" ? &options.bias_r_rad_s
                             : key == "walk_r" ? &options.walk_r_rad_s_sqrt_s
                                               : nullptr;
    double* const other = key == "sigma_t"  ? &options.sigma_t_m
                          : key == "bias_t" ? &options.bias_t_m_s
                          : key == "walk_t" ? &options.walk_t_m_s_sqrt_s
                          : key == "rate"   ? &options.rate_hz
                                            : nullptr;
    if (rotation != nullptr) {
      if (suffix != "deg" && suffix != "rad") return BadOption(item, "needs the unit deg or rad");
      *rotation = suffix == "deg" ? value * kRadPerDeg : value;
    } else if (other != nullptr) {
      if (!suffix.empty()) return BadOption(item, "takes a bare number (m, m/s or Hz)");
      *other = value;
    } else {
      return BadOption(item,
                       "unknown key; there are sigma_t, sigma_r, bias_t, bias_r, walk_t, walk_r, "
                       "rate, seed");
    }
  }
  if (options.rate_hz < 1 || options.rate_hz > 1000) {
    return BadOption("rate", "must lie in 1 to 1000 Hz");
  }
  return options;
}

std::string Describe(const SyntheticDrOptions& o) {
  return tools::Format(
      "sigma_t=%.9g,sigma_r=%.9gdeg,bias_t=%.9g,bias_r=%.9gdeg,walk_t=%.9g,walk_r=%.9gdeg,"
      "rate=%.9g,seed=%u",
      o.sigma_t_m, o.sigma_r_rad / kRadPerDeg, o.bias_t_m_s, o.bias_r_rad_s / kRadPerDeg,
      o.walk_t_m_s_sqrt_s, o.walk_r_rad_s_sqrt_s / kRadPerDeg, o.rate_hz, o.seed);
}

Result<std::vector<DrState>> MakeSyntheticDr(const std::vector<GroundTruth>& ground_truth,
                                             const SyntheticDrOptions& o,
                                             std::vector<std::string>& warnings) {
  if (ground_truth.size() < 2) {
    return Error{ErrorCode::kBadData,
                 "--dr-from-groundtruth: the recording has no ground truth to make it from"};
  }
  std::vector<StampedPose> truth;
  DurationUs largest_gap;
  for (const GroundTruth& sample : ground_truth) {
    if (!truth.empty()) largest_gap = std::max(largest_gap, sample.utime - truth.back().utime);
    truth.push_back({sample.utime, sample.T_GB});
  }
  if (largest_gap > Milliseconds(200)) {
    warnings.push_back(tools::Format(
        "ground truth has a gap of %.2f s; the synthetic dead reckoning bridges it on the "
        "geodesic",
        largest_gap.seconds()));
  }

  const Matrix6d white = Diagonal(Square(o.sigma_t_m) * kFrameRateHz,  //
                                  Square(o.sigma_r_rad) * kFrameRateHz);
  const Matrix6d walk = Diagonal(Square(o.walk_t_m_s_sqrt_s), Square(o.walk_r_rad_s_sqrt_s));
  Vector6d bias = Draw(o.seed, kBiasStream, 0, o.bias_t_m_s, o.bias_r_rad_s);
  // Joint covariance of (pose error, bias).
  Matrix12d cov = Matrix12d::Zero();
  cov.bottomRightCorner<6, 6>() = Diagonal(Square(o.bias_t_m_s), Square(o.bias_r_rad_s));

  std::vector<DrState> states;
  const Utime begin = truth.front().utime;
  SE3 T_GBa = truth.front().T;
  for (uint64_t k = 0;; ++k) {
    const Utime utime = begin + DurationFromSeconds(static_cast<double>(k) / o.rate_hz);
    if (utime > truth.back().utime) break;
    DrState state;
    state.utime = utime;
    state.wheels_alive = state.imu_alive = state.synthetic = true;
    state.cov_twist_white = white;
    if (k > 0) {
      const DrState& before = states.back();
      const double dt = (utime - before.utime).seconds();
      const SE3 T_GBb = PoseAt(truth, utime);
      const SE3 T_BaBb = T_GBa.inverse() * T_GBb;
      const double root = std::sqrt(kFrameRateHz * dt);
      const Vector6d noise =
          Draw(o.seed, kNoiseStream, k, o.sigma_t_m * root, o.sigma_r_rad * root);
      state.T_OB = before.T_OB * T_BaBb * SE3::Exp(noise + bias * dt);
      const Vector6d twist = T_BaBb.Log() / dt + bias;
      state.v_OB_B = twist.head<3>();
      state.w_OB_B = twist.tail<3>();

      Matrix12d F = Matrix12d::Identity();
      F.topLeftCorner<6, 6>() = T_BaBb.inverse().Adjoint();
      F.topRightCorner<6, 6>() = Matrix6d::Identity() * dt;
      cov = F * cov * F.transpose();
      cov.topLeftCorner<6, 6>() += white * dt;
      cov.bottomRightCorner<6, 6>() += walk * dt;
      cov = (0.5 * (cov + cov.transpose())).eval();
      bias += Draw(o.seed, kBiasStream, k, o.walk_t_m_s_sqrt_s * std::sqrt(dt),
                   o.walk_r_rad_s_sqrt_s * std::sqrt(dt));
      T_GBa = T_GBb;
    }
    state.cov_T_OB = cov.topLeftCorner<6, 6>();
    state.cov_twist_coherent = cov.bottomRightCorner<6, 6>();
    states.push_back(state);
  }
  // The first state has no interval behind it; it moves as the second does.
  if (states.size() > 1) {
    states.front().v_OB_B = states[1].v_OB_B;
    states.front().w_OB_B = states[1].w_OB_B;
  }
  return states;
}

}  // namespace gw::importer

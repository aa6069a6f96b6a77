#include "tools/data/import/turn_match.h"

#include <algorithm>
#include <cmath>

#include "tools/data/import/trajectory.h"

namespace gw::importer {
namespace {

constexpr DurationUs kWindow = Milliseconds(500);
constexpr DurationUs kLongestWindow = Milliseconds(1500);  // a gap: nothing is known of its inside
constexpr int kFewestWindows = 10;
constexpr double kGoodCorrelation = 0.9;

void AddWindow(const TurnWindow& window, TurnReference* reference) {
  if (window.end - window.begin > kLongestWindow) return;
  reference->turned_rad += window.turn_B.norm();
  reference->windows.push_back(window);
}

void AddWheels(const std::vector<WheelSample>& wheels, TurnReference* reference) {
  std::optional<TurnWindow> open;
  for (const WheelSample& sample : wheels) {
    if (open && sample.utime_begin != open->end) open.reset();
    if (!open) open = TurnWindow{sample.utime_begin, sample.utime_begin};
    open->turn_B.z() += sample.dyaw_rad;
    open->end = sample.utime;
    if (open->end - open->begin < kWindow) continue;
    AddWindow(*open, reference);
    open.reset();
  }
}

void AddTruth(const std::vector<GroundTruth>& truth, TurnReference* reference) {
  size_t a = 0;
  for (size_t b = 1; b < truth.size(); ++b) {
    if (truth[b].utime - truth[a].utime < kWindow) continue;
    const Eigen::Quaterniond q = truth[a].T_GB.rotation().conjugate() * truth[b].T_GB.rotation();
    AddWindow({truth[a].utime, truth[b].utime, LogSO3(q)}, reference);
    a = b;
  }
}

}  // namespace

TurnReference MakeTurnReference(const Recording& recording) {
  TurnReference reference;
  if (!recording.wheel.empty()) {
    reference.name = "wheels";
    reference.planar = true;
    AddWheels(recording.wheel, &reference);
  } else if (!recording.ground_truth.empty()) {
    reference.name = "ground truth";
    AddTruth(recording.ground_truth, &reference);
  }
  return reference;
}

TurnMatcher::TurnMatcher(const TurnReference& reference, const std::vector<ImuSample>& imu)
    : reference_(reference) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < imu.size(); ++i) {
    if (i > 0) {
      const double dt = (imu[i].utime - imu[i - 1].utime).seconds();
      sum += 0.5 * dt * (imu[i].w_I_rad_s + imu[i - 1].w_I_rad_s);
    }
    times_.push_back(imu[i].utime);
    integral_.push_back(sum);
  }
}

std::optional<Eigen::Vector3d> TurnMatcher::Integral(Utime utime) const {
  const auto after = std::lower_bound(times_.begin(), times_.end(), utime);
  if (after == times_.end() || (after == times_.begin() && *after != utime)) return std::nullopt;
  const auto b = static_cast<size_t>(after - times_.begin());
  if (times_[b] == utime) return integral_[b];
  const double share = (utime - times_[b - 1]).seconds() / (times_[b] - times_[b - 1]).seconds();
  return integral_[b - 1] + share * (integral_[b] - integral_[b - 1]);
}

std::optional<TurnFit> TurnMatcher::Fit(const Eigen::Quaterniond& R_BI, DurationUs offset) const {
  // Deviations of turn rates from their means: a constant bias drops out.
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> rates;  // reference, gyro
  Eigen::Vector3d mean_turn = Eigen::Vector3d::Zero(), mean_gyro = Eigen::Vector3d::Zero();
  TurnFit fit;
  for (const TurnWindow& window : reference_.windows) {
    const auto begin = Integral(window.begin + offset);
    const auto end = Integral(window.end + offset);
    if (!begin || !end) continue;
    const double length = (window.end - window.begin).seconds();
    Eigen::Vector3d gyro = R_BI * (*end - *begin) / length;
    if (reference_.planar) gyro.head<2>().setZero();
    rates.emplace_back(window.turn_B / length, gyro);
    mean_turn += rates.back().first;
    mean_gyro += gyro;
    fit.turned_rad += window.turn_B.norm();
  }
  if (std::ssize(rates) < kFewestWindows) return std::nullopt;
  mean_turn /= static_cast<double>(rates.size());
  mean_gyro /= static_cast<double>(rates.size());
  double turn_turn = 0, turn_gyro = 0, gyro_gyro = 0;
  for (const auto& [turn, gyro] : rates) {
    turn_turn += (turn - mean_turn).squaredNorm();
    turn_gyro += (turn - mean_turn).dot(gyro - mean_gyro);
    gyro_gyro += (gyro - mean_gyro).squaredNorm();
  }
  if (turn_turn <= 0) return std::nullopt;
  fit.scale = turn_gyro / turn_turn;
  fit.correlation = gyro_gyro > 0 ? turn_gyro / std::sqrt(turn_turn * gyro_gyro) : 0;
  return fit;
}

std::optional<DurationUs> TurnMatcher::FindOffset(const Eigen::Quaterniond& R_BI,
                                                  DurationUs around) const {
  std::optional<DurationUs> best;
  double best_correlation = kGoodCorrelation;
  const auto search = [&](DurationUs center, int64_t range_ms, int64_t step_ms) {
    for (int64_t ms = -range_ms; ms <= range_ms; ms += step_ms) {
      const DurationUs offset = center + Milliseconds(ms);
      const auto fit = Fit(R_BI, offset);
      // A few windows at the edge agree by chance: most of the turning has to be covered.
      if (!fit || fit->turned_rad < 0.5 * reference_.turned_rad) continue;
      if (std::abs(fit->correlation) <= best_correlation) continue;
      best_correlation = std::abs(fit->correlation);
      best = offset;
    }
  };
  search(around, 30000, 100);
  if (best) search(*best, 100, 10);
  return best;
}

}  // namespace gw::importer

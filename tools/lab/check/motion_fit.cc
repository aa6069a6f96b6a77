#include "tools/lab/check/motion_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "common/core/median.h"

namespace gw::check {
namespace {

constexpr DurationUs kLongestGap = Milliseconds(300);
constexpr int kFewestSteps = 20;

// The fit at one delay.
struct Trial {
  double scale = 0, bias = 0, sigma_scale = 0, rest = 0, correlation = 0, moved = 0;
  int steps = 0;
};

// How much a residual counts.
class Weight {
 public:
  Weight() = default;  // all alike
  // Cauchy's weight, tuned to 95 % efficiency: P. W. Holland, R. E. Welsch, "Robust regression
  // using iteratively reweighted least-squares", Communications in Statistics A6 (1977), table 1.
  explicit Weight(double noise) : limit_(2.385 * noise) {}
  double operator()(double residual) const {
    return limit_ > 0 ? 1 / (1 + std::pow(residual / limit_, 2)) : 1;
  }

 private:
  double limit_ = 0;
};

// `previous` with `weight`: the solution whose residuals tell the weights.
std::optional<Trial> FitAt(const std::vector<MotionStep>& reference, const MotionSum& other,
                           DurationUs delay, const Weight& weight = {},
                           const Trial& previous = {}) {
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  double square = 0, moved = 0, other_moved = 0;
  Trial trial;
  for (const MotionStep& step : reference) {
    const auto begin = other.At(step.begin + delay);
    const auto end = other.At(step.end + delay);
    if (!begin || !end) continue;
    const Eigen::Vector2d row(step.motion, (step.end - step.begin).seconds());
    const double value = *end - *begin;
    const double w = weight(value - row.dot(Eigen::Vector2d(previous.scale, previous.bias)));
    normal += w * row * row.transpose();
    right += w * row * value;
    square += w * value * value;
    moved += std::abs(step.motion);
    other_moved += std::abs(value);
    ++trial.steps;
  }
  if (trial.steps < kFewestSteps || normal.determinant() <= 0) return std::nullopt;
  trial.moved = std::max(moved, other_moved);
  const Eigen::Vector2d solution = normal.ldlt().solve(right);
  trial.scale = solution.x();
  trial.bias = solution.y();
  trial.rest = std::max(0.0, square - solution.dot(right));
  const double variance = trial.rest / (trial.steps - 2);
  trial.sigma_scale = std::sqrt(variance * normal.inverse()(0, 0));
  // Sums of squares of both rates after the bias is taken off.
  const double reference_square = normal(0, 0) - normal(0, 1) * normal(0, 1) / normal(1, 1);
  const double other_square = square - right.y() * right.y() / normal(1, 1);
  if (other_square > 0 && reference_square > 0) {
    trial.correlation = trial.scale * std::sqrt(reference_square / other_square);
  }
  return trial;
}

// The same at the delay that was found, but steps in which a wheel slips, or vision jumps, count
// little.
Trial Robust(const std::vector<MotionStep>& reference, const MotionSum& other, DurationUs delay,
             Trial trial) {
  for (int round = 0; round < 10; ++round) {
    std::vector<double> sizes;
    for (const MotionStep& step : reference) {
      const auto begin = other.At(step.begin + delay);
      const auto end = other.At(step.end + delay);
      if (!begin || !end) continue;
      sizes.push_back(std::abs(*end - *begin - trial.scale * step.motion -
                               trial.bias * (step.end - step.begin).seconds()));
    }
    const auto next =
        FitAt(reference, other, delay, Weight(kSigmaOverMedian * MedianOf(&sizes)), trial);
    if (!next) return trial;
    trial = *next;
  }
  return trial;
}

}  // namespace

void MotionSum::Add(Utime utime, double sum) {
  if (!times_.empty() && utime <= times_.back()) return;
  times_.push_back(utime);
  sums_.push_back(sum);
}

std::optional<double> MotionSum::At(Utime utime) const {
  const auto after = std::lower_bound(times_.begin(), times_.end(), utime);
  if (after == times_.end()) return std::nullopt;
  const auto b = static_cast<size_t>(after - times_.begin());
  if (times_[b] == utime) return sums_[b];
  if (b == 0 || times_[b] - times_[b - 1] > kLongestGap) return std::nullopt;
  const double share = (utime - times_[b - 1]).seconds() / (times_[b] - times_[b - 1]).seconds();
  return sums_[b - 1] + share * (sums_[b] - sums_[b - 1]);
}

std::optional<MotionFit> FitMotion(const std::vector<MotionStep>& reference, const MotionSum& other,
                                   DurationUs around, double least) {
  std::optional<Trial> best;
  int64_t best_ms = 0;
  constexpr int64_t kRange = 500, kStep = 5;  // ms
  for (int64_t ms = -kRange; ms <= kRange; ms += kStep) {
    const auto trial = FitAt(reference, other, around + Milliseconds(ms));
    if (!trial || trial->moved < least) continue;
    if (best && trial->rest / trial->steps >= best->rest / best->steps) continue;
    best = trial;
    best_ms = ms;
  }
  if (!best) return std::nullopt;
  const Trial robust = Robust(reference, other, around + Milliseconds(best_ms), *best);
  MotionFit fit{robust.scale, robust.sigma_scale, 0, 0, best->correlation, best->moved};
  fit.delay_s = (around.us + best_ms * 1000) * 1e-6;
  // Parabola through neighbours that are far enough for the curvature to show.
  constexpr int64_t kSide = 20;
  const auto before = FitAt(reference, other, around + Milliseconds(best_ms - kSide));
  const auto after = FitAt(reference, other, around + Milliseconds(best_ms + kSide));
  if (!before || !after) return fit;
  const double h = kSide * 1e-3;
  // Mean squares, not sums: at the edges of the recording a step more or less is covered.
  const double rest = best->rest / best->steps;
  const double rest_before = before->rest / before->steps, rest_after = after->rest / after->steps;
  const double curvature = (rest_before + rest_after - 2 * rest) / (h * h);
  if (curvature <= 0) return fit;
  const double slope = (rest_after - rest_before) / (2 * h);
  fit.delay_s -= std::clamp(slope / curvature, -h, h);
  fit.sigma_delay_s = std::sqrt(2 * rest / (best->steps - 3) / curvature);
  return fit;
}

}  // namespace gw::check

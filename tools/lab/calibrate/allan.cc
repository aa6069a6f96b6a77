#include "tools/lab/calibrate/allan.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/check.h"

namespace gw::calibrate {
namespace {

constexpr int kTerms = 4;  // quantisation, white noise, flicker noise, random walk
constexpr int kRounds = 6;
// Estimates at neighbouring averaging times share their data, which the fit takes for independent.
// In 180 simulated recordings of 10 to 60 minutes the random walk's error was 1.5 times the
// standard deviation of the fit, that of the white noise 0.9 times.
constexpr double kShared = 1.5;

using Terms = Eigen::Matrix<double, kTerms, 1>;

// What each term adds to the variance at tau, for a coefficient of one.
Terms Basis(double tau) {
  return {3 / (tau * tau), 1 / tau, 2 * std::log(2.0) / M_PI, tau / 3};
}

struct Weighted {
  Eigen::Matrix<double, Eigen::Dynamic, kTerms> rows;
  Eigen::VectorXd values;
};

// Points over their standard deviations, which go with the variance that the model expects.
Weighted Weigh(const std::vector<AllanPoint>& points, const Terms& model) {
  const auto n = static_cast<Eigen::Index>(points.size());
  Weighted out{Eigen::Matrix<double, Eigen::Dynamic, kTerms>(n, kTerms), Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const AllanPoint& point = points[static_cast<size_t>(i)];
    const Terms basis = Basis(point.tau_s);
    const double expected = model.isZero() ? point.variance : basis.dot(model);
    const double sigma = point.relative * std::max(expected, 1e-300);
    out.rows.row(i) = basis.transpose() / sigma;
    out.values[i] = point.variance / sigma;
  }
  return out;
}

// The best of all subsets of the terms whose coefficients are not negative.
Terms SolveNonNegative(const Weighted& in) {
  Terms best = Terms::Zero();
  double least = in.values.squaredNorm();
  for (int subset = 1; subset < 1 << kTerms; ++subset) {
    std::vector<int> used;
    for (int k = 0; k < kTerms; ++k) {
      if ((subset >> k & 1) != 0) used.push_back(k);
    }
    Eigen::MatrixXd rows(in.rows.rows(), static_cast<Eigen::Index>(used.size()));
    for (size_t k = 0; k < used.size(); ++k) {
      // Columns differ by many orders of magnitude: scaled to unit length.
      rows.col(static_cast<Eigen::Index>(k)) = in.rows.col(used[k]).normalized();
    }
    const Eigen::VectorXd x = rows.colPivHouseholderQr().solve(in.values);
    const double cost = (rows * x - in.values).squaredNorm();
    if (x.minCoeff() < 0 || cost >= least) continue;
    least = cost;
    best.setZero();
    for (size_t k = 0; k < used.size(); ++k) {
      best[used[k]] = x[static_cast<Eigen::Index>(k)] / in.rows.col(used[k]).norm();
    }
  }
  return best;
}

// Standard deviations of the coefficients, all four free, from the points' errors or the scatter
// about the model, whichever is larger.
Terms SigmasOf(const Weighted& in, const Terms& model) {
  const Terms scale = in.rows.colwise().norm();
  const Eigen::Matrix<double, Eigen::Dynamic, kTerms> scaled =
      in.rows * scale.cwiseInverse().asDiagonal();
  const Eigen::Matrix4d covariance = (scaled.transpose() * scaled).inverse();
  const double scatter = (in.rows * model - in.values).squaredNorm() /
                         std::max<double>(1, static_cast<double>(in.values.size()) - kTerms);
  const double factor = std::sqrt(std::max(1.0, scatter));
  return factor * covariance.diagonal().cwiseMax(0).cwiseSqrt().cwiseQuotient(scale);
}

// The square root of a coefficient and of its error. Near zero the error of the root is the root of
// the error.
NoiseTerm RootOf(double coefficient, double sigma) {
  const double value = std::sqrt(std::max(0.0, coefficient));
  const double high = std::sqrt(std::max(0.0, coefficient) + sigma);
  return {value, high - value > value ? high : sigma / (2 * value)};
}

}  // namespace

std::vector<AllanPoint> AllanVariance(std::span<const double> rate, double dt_s) {
  std::vector<double> sum(rate.size() + 1, 0.0);
  double mean = 0;
  for (const double value : rate) mean += value / static_cast<double>(rate.size());
  // The mean cancels in the second difference; without it the sums stay small and exact.
  for (size_t i = 0; i < rate.size(); ++i) sum[i + 1] = sum[i] + (rate[i] - mean) * dt_s;
  std::vector<AllanPoint> points;
  for (size_t m = 1; 9 * m <= rate.size(); m *= 2) {
    const double tau = static_cast<double>(m) * dt_s;
    double total = 0;
    const size_t count = sum.size() - 2 * m;
    for (size_t i = 0; i < count; ++i) {
      const double second = sum[i + 2 * m] - 2 * sum[i + m] + sum[i];
      total += second * second;
    }
    const double windows = static_cast<double>(rate.size()) / static_cast<double>(m);
    points.push_back(
        {tau, total / (2 * tau * tau * static_cast<double>(count)), std::sqrt(2 / (windows - 1))});
  }
  return points;
}

NoiseModel FitNoise(const std::vector<AllanPoint>& points) {
  GW_CHECK(points.size() > kTerms);
  Terms model = Terms::Zero();
  Weighted weighted = Weigh(points, model);
  for (int round = 0; round < kRounds; ++round) {
    model = SolveNonNegative(weighted);
    weighted = Weigh(points, model);
  }
  const Terms sigmas = SigmasOf(weighted, model);
  return {RootOf(model[1], sigmas[1]), RootOf(model[2], kShared * sigmas[2]),
          RootOf(model[3], kShared * sigmas[3])};
}

}  // namespace gw::calibrate

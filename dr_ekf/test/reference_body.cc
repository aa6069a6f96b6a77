#include "dr_ekf/test/reference_body.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace gw::dr_ekf {
namespace {

struct Pair {  // planar motion over one window, by the reference (in R) and by the wheels (in B)
  Eigen::Vector2d reference, wheels;
  double turn;
};

std::optional<SE3> PoseAt(const std::vector<StampedPose>& poses, Utime utime) {
  const auto after = std::lower_bound(poses.begin(), poses.end(), utime,
                                      [](const StampedPose& p, Utime t) { return p.utime < t; });
  if (after == poses.begin() || after == poses.end()) return std::nullopt;
  const StampedPose& before = *(after - 1);
  const double f = (utime - before.utime).seconds() / (after->utime - before.utime).seconds();
  return Interpolate(before.T, after->T, f);
}

std::vector<Pair> Pairs(const std::vector<StampedPose>& reference,
                        const std::vector<StampedPose>& wheels, double clock_ahead_s) {
  constexpr double kWindow = 1;  // s
  std::vector<Pair> out;
  size_t j = 0;
  for (size_t i = 0; i < reference.size(); i = std::max(i + 1, j)) {
    j = i;
    while (j < reference.size() && (reference[j].utime - reference[i].utime).seconds() < kWindow) {
      ++j;
    }
    if (j >= reference.size()) break;
    if ((reference[j].utime - reference[i].utime).seconds() > 4 * kWindow) continue;
    const DurationUs ahead = DurationFromSeconds(clock_ahead_s);
    const auto a = PoseAt(wheels, reference[i].utime - ahead);
    const auto b = PoseAt(wheels, reference[j].utime - ahead);
    if (!a || !b) continue;
    const SE3 motion = reference[i].T.inverse() * reference[j].T;
    if (motion.translation().norm() < 0.02) continue;
    out.push_back({motion.translation().head<2>(), (a->inverse() * *b).translation().head<2>(),
                   LogSO3(motion.rotation()).z()});
  }
  return out;
}

// wheels = R(psi) reference + (1 - R(turn)) p, linear in (cos psi, sin psi, p), whose first two are
// free in size: that is the scale. Cost: median of the residual.
struct Fit {
  SE3 T_BR;
  double cost = std::numeric_limits<double>::infinity();
};
Fit FitPairs(const std::vector<Pair>& pairs) {
  Fit fit;
  if (pairs.size() < 10) return fit;
  Eigen::Vector4d x(1, 0, 0, 0);
  for (int round = 0; round < 8; ++round) {
    std::vector<double> sizes;
    std::vector<std::pair<Eigen::Matrix<double, 2, 4>, Eigen::Vector2d>> rows;
    for (const Pair& pair : pairs) {
      Eigen::Matrix<double, 2, 4> A;
      const Eigen::Vector2d r = pair.reference;
      A << r.x(), -r.y(), 1 - std::cos(pair.turn), std::sin(pair.turn),  //
          r.y(), r.x(), -std::sin(pair.turn), 1 - std::cos(pair.turn);
      rows.emplace_back(A, pair.wheels);
      sizes.push_back((pair.wheels - A * x).norm());
    }
    std::vector<double> sorted = sizes;
    std::nth_element(sorted.begin(), sorted.begin() + sorted.size() / 2, sorted.end());
    const double median = sorted[sorted.size() / 2];
    Eigen::Matrix4d N = Eigen::Matrix4d::Identity() * 1e-6;
    Eigen::Vector4d b = Eigen::Vector4d::Zero();
    for (size_t i = 0; i < rows.size(); ++i) {
      const double weight = 1 / std::max(1.0, sizes[i] / (1.5 * median));
      N += weight * rows[i].first.transpose() * rows[i].first;
      b += weight * rows[i].first.transpose() * rows[i].second;
    }
    x = N.ldlt().solve(b);
    fit.cost = median;
  }
  fit.T_BR =
      SE3(Eigen::Quaterniond(Eigen::AngleAxisd(std::atan2(x[1], x[0]), Eigen::Vector3d::UnitZ())),
          {x[2], x[3], 0});
  return fit;
}

}  // namespace

ReferenceBody FitReferenceBody(const std::vector<StampedPose>& reference,
                               const std::vector<StampedPose>& wheels) {
  ReferenceBody best;
  Fit best_fit;
  constexpr double kMostApart = 1, kStep = 0.05;  // s
  for (double ahead = -kMostApart; ahead <= kMostApart; ahead += kStep) {
    const Fit fit = FitPairs(Pairs(reference, wheels, ahead));
    if (fit.cost >= best_fit.cost) continue;
    best_fit = fit;
    best = {fit.T_BR, ahead};
  }
  return best;
}

std::vector<StampedPose> InBodyOfWheels(const std::vector<StampedPose>& reference,
                                        const ReferenceBody& body) {
  std::vector<StampedPose> out;
  out.reserve(reference.size());
  for (const StampedPose& pose : reference) {
    out.push_back(
        {pose.utime - DurationFromSeconds(body.clock_ahead_s), pose.T * body.T_BR.inverse()});
  }
  return out;
}

double MedianPeriod(const std::vector<StampedPose>& poses) {
  std::vector<double> periods;
  for (size_t i = 1; i < poses.size(); ++i) {
    periods.push_back((poses[i].utime - poses[i - 1].utime).seconds());
  }
  std::nth_element(periods.begin(), periods.begin() + periods.size() / 2, periods.end());
  return periods[periods.size() / 2];
}

}  // namespace gw::dr_ekf

#include "tools/data/foxglove/truth_tie.h"

#include <cmath>

namespace gw::foxglove {
namespace {

// How far a pose is trusted: the accuracy of the estimates, docs/results.md. Only their ratio
// counts, and only until the way is some metres long.
constexpr double kSigmaPosition = 0.02;  // m
constexpr double kSigmaHeading = 0.01;   // rad

std::complex<double> Horizontal(const Eigen::Vector3d& p) {
  return {p.x(), p.y()};
}

}  // namespace

double YawOf(const Eigen::Quaterniond& q) {
  return 2 * std::atan2(q.z(), q.w());
}

void TruthTie::Add(const SE3& T_WB, const SE3& T_GB) {
  ++count_;
  const auto n = static_cast<double>(count_);
  const Eigen::Vector3d before_W = T_WB.translation() - mean_W_;
  mean_W_ += before_W / n;
  mean_G_ += (T_GB.translation() - mean_G_) / n;
  cross_ += std::conj(Horizontal(T_GB.translation() - mean_G_)) * Horizontal(before_W);
  const Eigen::Quaterniond q_WG = T_WB.rotation() * T_GB.rotation().conjugate();
  heading_ += std::polar(1.0, YawOf(q_WG));
}

SE3 TruthTie::T_WG() const {
  const double yaw = std::arg(cross_ / (kSigmaPosition * kSigmaPosition) +
                              heading_ / (kSigmaHeading * kSigmaHeading));
  const Eigen::Quaterniond q(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  return {q, mean_W_ - q * mean_G_};
}

}  // namespace gw::foxglove

#include "frontend/core/motion/length_ratio.h"

#include <cmath>

namespace gw::frontend {
namespace {

// A window of 0.3 m: its ends are known to a centimetre, it tells the ratio to 3 %.
constexpr double kLeastSquare = 0.1;  // m^2
constexpr double kWorthMore = 4;
// Wheels may be this late, and shift a way by so much times the gain of speed; that has to be less
// than this share of it (the least fault, FaultOf).
constexpr double kLate = 0.1;  // s
constexpr double kShare = 0.05;

}  // namespace

void LengthRatio::Add(const Window& window) {
  const Eigen::Vector2d &dr = window.by_dr, &vision = window.by_vision;
  if (kLate * std::abs(window.gained_m_s) > kShare * dr.norm()) return;
  product_ += Eigen::Vector2d(dr.dot(vision), dr.x() * vision.y() - dr.y() * vision.x());
  square_ += dr.squaredNorm();
  square_of_vision_ += vision.squaredNorm();
  const double spread = DrDisagreement::kFactorSigma * vision.norm();
  noise_ += 2 * (window.variance + spread * spread);
}

// One factor leaves no more than the noise.
bool LengthRatio::AllTellIt() const {
  return square_of_vision_ - product_.squaredNorm() / square_ <= noise_;
}

std::optional<double> LengthRatio::Fault() const {
  if (square_ < kLeastSquare || product_.x() <= 0 || !AllTellIt()) return std::nullopt;
  const DrConstantFault fault = FaultOf(value(), std::atan2(product_.y(), product_.x()), 1);
  return fault.direction ? std::nullopt : fault.way_factor;
}

void LengthRatio::Corrected(double factor) {
  product_ /= factor;
  square_of_vision_ /= factor * factor;
  corrected_at_ = square_;
}

bool LengthRatio::IsBetterNow() const {
  return corrected_at_ > 0 && square_ >= kWorthMore * corrected_at_ && AllTellIt();
}

}  // namespace gw::frontend

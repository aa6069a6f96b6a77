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

void LengthRatio::Add(const Eigen::Vector2d& by_dr, const Eigen::Vector2d& by_vision,
                      double gained_m_s) {
  if (kLate * std::abs(gained_m_s) > kShare * by_dr.norm()) return;
  const double across = by_dr.x() * by_vision.y() - by_dr.y() * by_vision.x();
  product_ += Eigen::Vector2d(by_dr.dot(by_vision), across);
  square_ += by_dr.squaredNorm();
}

std::optional<double> LengthRatio::Fault() const {
  if (square_ < kLeastSquare || product_.x() <= 0) return std::nullopt;
  const DrConstantFault fault = FaultOf(value(), std::atan2(product_.y(), product_.x()), 1);
  return fault.direction ? std::nullopt : fault.way_factor;
}

void LengthRatio::Corrected(double factor) {
  product_ /= factor;
  corrected_at_ = square_;
}

bool LengthRatio::IsBetterNow() const {
  return corrected_at_ > 0 && square_ >= kWorthMore * corrected_at_;
}

}  // namespace gw::frontend

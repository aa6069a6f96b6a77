#include "frontend/core/motion/dr_disagreement.h"

#include <cmath>

#include "common/core/format.h"

namespace gw::frontend {
namespace {

constexpr double kMemory = 20;  // windows
// A constant explains the motions when it leaves this share of their squares.
constexpr double kUnexplained = 0.1;
// Sums of squares from which there is something to explain: 1 m in steps of 0.3 m, 1 rad likewise.
constexpr double kLeastWay2 = 0.3;
constexpr double kLeastTurn2 = 0.3;
// Within these DR is as it should be, or calibration by vision takes care of it.
constexpr double kRightFactor = 0.05;
constexpr double kRightDirection = 0.05;  // rad

}  // namespace

void DrDisagreement::Add(const SE3& T_dr, const SE3& T_vision) {
  const std::complex<double> dr(T_dr.translation().x(), T_dr.translation().y());
  const std::complex<double> vision(T_vision.translation().x(), T_vision.translation().y());
  const double dr_turn = LogSO3(T_dr.rotation()).z();
  const double vision_turn = LogSO3(T_vision.rotation()).z();
  const double kept = 1 - 1 / kMemory;
  cross_way_ = kept * cross_way_ + vision * std::conj(dr);
  dr_way2_ = kept * dr_way2_ + std::norm(dr);
  vision_way2_ = kept * vision_way2_ + std::norm(vision);
  cross_turn_ = kept * cross_turn_ + vision_turn * dr_turn;
  dr_turn2_ = kept * dr_turn2_ + dr_turn * dr_turn;
  vision_turn2_ = kept * vision_turn2_ + vision_turn * vision_turn;
}

DrConstantFault DrDisagreement::Explain() const {
  DrConstantFault out;
  if (vision_way2_ > kLeastWay2 && dr_way2_ > 0) {
    const std::complex<double> factor = cross_way_ / dr_way2_;
    const double left = vision_way2_ - std::norm(cross_way_) / dr_way2_;
    if (left < kUnexplained * vision_way2_) {
      if (std::abs(std::log(std::abs(factor))) > kRightFactor) out.way_factor = std::abs(factor);
      if (std::abs(std::arg(factor)) > kRightDirection) out.direction = std::arg(factor);
    }
  }
  if (vision_turn2_ > kLeastTurn2 && dr_turn2_ > 0) {
    const double factor = cross_turn_ / dr_turn2_;
    const double left = vision_turn2_ - cross_turn_ * cross_turn_ / dr_turn2_;
    const bool explained = left < kUnexplained * vision_turn2_;
    if (explained && std::abs(factor - 1) > kRightFactor) out.turn_factor = factor;
  }
  return out;
}

std::string Describe(const DrConstantFault& fault) {
  std::string out;
  const auto add = [&out](const std::string& text) { out += (out.empty() ? "" : "; ") + text; };
  if (fault.way_factor) {
    add("its way is " + FormatFixed(1 / *fault.way_factor, 3) +
        " times vision's: multiply ticks_per_metre by " + FormatFixed(1 / *fault.way_factor, 3) +
        ", or check the unit of the odometry and the camera's baseline or depth_unit_m");
  }
  if (fault.direction) {
    const double degrees = *fault.direction * 180 / M_PI;
    add("vision drives " + FormatFixed(degrees, 1) + " degrees beside it: " +
        (std::abs(std::abs(degrees) - 180) < 10
             ? "wheels count backwards, or the camera looks backwards"
             : "turn T_BC by " + FormatFixed(-degrees, 1) +
                   " degrees about z of the body, or check the axes of the odometry"));
  }
  if (fault.turn_factor) {
    add("its turn is " + FormatFixed(1 / *fault.turn_factor, 3) + " times vision's" +
        (*fault.turn_factor < 0
             ? ": it turns the other way, check left and right, and the IMU's axes"
             : ": check track_width_m and the unit of the gyro"));
  }
  return out;
}

}  // namespace gw::frontend

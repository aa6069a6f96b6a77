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
  const Eigen::Vector2d dr = T_dr.translation().head<2>();
  const Eigen::Vector2d vision = T_vision.translation().head<2>();
  const double dr_turn = LogSO3(T_dr.rotation()).z();
  const double vision_turn = LogSO3(T_vision.rotation()).z();
  const double kept = 1 - 1 / kMemory;
  const double across = dr.x() * vision.y() - dr.y() * vision.x();
  cross_way_ = kept * cross_way_ + Eigen::Vector2d(dr.dot(vision), across);
  dr_way2_ = kept * dr_way2_ + dr.squaredNorm();
  vision_way2_ = kept * vision_way2_ + vision.squaredNorm();
  cross_turn_ = kept * cross_turn_ + vision_turn * dr_turn;
  dr_turn2_ = kept * dr_turn2_ + dr_turn * dr_turn;
  vision_turn2_ = kept * vision_turn2_ + vision_turn * vision_turn;
}

DrConstantFault FaultOf(double way_factor, double direction, double turn_factor) {
  DrConstantFault out;
  if (std::abs(std::log(way_factor)) > kRightFactor) out.way_factor = way_factor;
  if (std::abs(direction) > kRightDirection) out.direction = direction;
  if (std::abs(turn_factor - 1) > kRightFactor) out.turn_factor = turn_factor;
  return out;
}

DrConstantFault DrDisagreement::Explain() const {
  double way_factor = 1, direction = 0, turn_factor = 1;
  if (vision_way2_ > kLeastWay2 && dr_way2_ > 0) {
    const double left = vision_way2_ - cross_way_.squaredNorm() / dr_way2_;
    if (left < kUnexplained * vision_way2_) {
      way_factor = cross_way_.norm() / dr_way2_;
      direction = std::atan2(cross_way_.y(), cross_way_.x());
    }
  }
  if (vision_turn2_ > kLeastTurn2 && dr_turn2_ > 0) {
    const double left = vision_turn2_ - cross_turn_ * cross_turn_ / dr_turn2_;
    if (left < kUnexplained * vision_turn2_) turn_factor = cross_turn_ / dr_turn2_;
  }
  return FaultOf(way_factor, direction, turn_factor);
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

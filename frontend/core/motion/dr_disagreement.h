// What is wrong with dead reckoning (DR) that contradicts healthy vision? Most faults of a set-up
// are one constant: wheels in another frame, reversed, a wrong unit or radius, a camera turned on
// its base. The ways and turns of the compared windows tell it by least squares, on the floor (x,
// y, yaw of B):
//
//   vision's way = s R(phi) way of DR        vision's turn = k turn of DR
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "common/core/se3.h"

namespace gw::frontend {

struct DrConstantFault {
  // Vision's way over that of DR, > 0, and the angle from DR's direction to vision's, rad in
  // (-pi, pi]; empty where no constant explains the ways.
  std::optional<double> way_factor, direction;
  // Vision's turn over that of DR; empty where none explains the turns.
  std::optional<double> turn_factor;

  bool empty() const { return !way_factor && !direction && !turn_factor; }
};

// The parts of a constant that are not as they should be.
DrConstantFault FaultOf(double way_factor, double direction, double turn_factor);

class DrDisagreement {
 public:
  // One window, motions of the body.
  void Add(const SE3& T_dr, const SE3& T_vision);

  // From the newest twenty windows or so. Only what is not as it should be is set.
  DrConstantFault Explain() const;

 private:
  // Sums over ways: of DR's times vision's, along it and across, and the squares.
  Eigen::Vector2d cross_way_ = Eigen::Vector2d::Zero();
  double dr_way2_ = 0, vision_way2_ = 0;
  double cross_turn_ = 0, dr_turn2_ = 0, vision_turn2_ = 0;
};

// In words for HEALTH and reports, with what to set; empty when the fault is.
std::string Describe(const DrConstantFault& fault);

}  // namespace gw::frontend

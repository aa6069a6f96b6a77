#include "frontend/core/motion/dr_disagreement.h"

#include <cmath>

#include "common/core/format.h"

namespace gw::frontend {
namespace {

constexpr size_t kMemory = 20;  // windows
// Sums of squares from which there is something to explain: 1 m in steps of 0.3 m, 1 rad likewise.
constexpr double kLeastWay2 = 0.3;
constexpr double kLeastTurn2 = 0.3;
// Within these DR is as it should be, or calibration by vision takes care of it.
constexpr double kRightFactor = 0.05;
constexpr double kRightDirection = 0.05;  // rad

}  // namespace

void DrDisagreement::Add(const DrEvidence& evidence) {
  // Of the twist: the small steps of a curve, not its chord, are turned by a constant.
  const Vector6d dr = evidence.T_dr.Log(), vision = evidence.T_vision.Log();
  const auto way = [](const Vector6d& twist) { return std::complex(twist(0), twist(1)); };
  const auto of_way = [](const Matrix6d& cov) { return (cov(0, 0) + cov(1, 1)) / 2; };
  ways_.push_back({way(dr), way(vision), of_way(evidence.cov_dr), of_way(evidence.cov_vision)});
  turns_.push_back({dr(5), vision(5), evidence.cov_dr(5, 5), evidence.cov_vision(5, 5)});
  for (Pairs* pairs : {&ways_, &turns_}) {
    if (pairs->size() > kMemory) pairs->pop_front();
  }
}

// Vision's motion over that of DR by least squares; empty where vision's squares are below `least`
// in sum, or the squares that the factor of the others leaves of each window are more than
// expected.
std::optional<std::complex<double>> DrDisagreement::Factor(const Pairs& windows, double least) {
  struct Estimate {
    std::complex<double> factor = 0;
    double variance = 0;  // of one part
  };
  const auto variance_of = [](const Pair& w, const std::complex<double>& factor) {
    return w.var_vision + std::norm(factor) * w.var_dr +
           kFactorSigma * kFactorSigma * std::norm(w.vision);
  };
  const auto estimate = [&](const Pair* but) {
    std::complex<double> cross = 0;
    double squares = 0;
    for (const Pair& w : windows) {
      if (&w == but) continue;
      cross += std::conj(w.dr) * w.vision;
      squares += std::norm(w.dr);
    }
    Estimate out;
    if (squares <= 0) return out;
    out.factor = cross / squares;
    for (const Pair& w : windows) {
      if (&w == but) continue;
      out.variance += std::norm(w.dr) / (squares * squares) * variance_of(w, out.factor);
    }
    return out;
  };
  double moved = 0, left = 0, expected = 0;
  for (const Pair& w : windows) {
    const Estimate others = estimate(&w);
    moved += std::norm(w.vision);
    left += std::norm(w.vision - others.factor * w.dr);
    expected += 2 * (variance_of(w, others.factor) + std::norm(w.dr) * others.variance);
  }
  if (moved <= least || left > expected) return std::nullopt;
  return estimate(nullptr).factor;
}

DrConstantFault FaultOf(double way_factor, double direction, double turn_factor) {
  DrConstantFault out;
  if (std::abs(std::log(way_factor)) > kRightFactor) out.way_factor = way_factor;
  if (std::abs(direction) > kRightDirection) out.direction = direction;
  if (std::abs(turn_factor - 1) > kRightFactor) out.turn_factor = turn_factor;
  return out;
}

DrExplanation DrDisagreement::Explain() const {
  DrExplanation out;
  out.way = Factor(ways_, kLeastWay2);
  if (const auto turn = Factor(turns_, kLeastTurn2)) out.turn = turn->real();
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

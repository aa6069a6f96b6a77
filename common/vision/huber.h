// Huber's loss, for squared residuals. delta2: square of the radius within which it is quadratic.
#pragma once

#include <cmath>

namespace gw {

inline double HuberCost(double squared, double delta2) {
  return squared <= delta2 ? squared : 2.0 * std::sqrt(squared * delta2) - delta2;
}

// Its derivative by `squared`: what the residual counts in reweighted least squares.
inline double HuberWeight(double squared, double delta2) {
  return squared <= delta2 ? 1.0 : std::sqrt(delta2 / squared);
}

}  // namespace gw

// Robust losses of squared residuals. radius2: square of the radius within which they are about
// quadratic.
#pragma once

#include <cmath>

namespace gw {

// Huber's: grows with the residual beyond the radius. For observations, most of which are right.
inline double HuberCost(double squared, double radius2) {
  return squared <= radius2 ? squared : 2.0 * std::sqrt(squared * radius2) - radius2;
}

// Its derivative by `squared`: what the residual counts in reweighted least squares.
inline double HuberWeight(double squared, double radius2) {
  return squared <= radius2 ? 1.0 : std::sqrt(radius2 / squared);
}

// Cauchy's: far beyond the radius a residual no longer pulls. For a witness that may be wrong as a
// whole.
inline double CauchyCost(double squared, double radius2) {
  return radius2 * std::log1p(squared / radius2);
}

}  // namespace gw

// Evidence as the logarithm of a likelihood ratio.
#pragma once

#include <cmath>

namespace gw {

// A thousand to one decides.
inline const double kDecisiveLogOdds = std::log(1000.0);

// Log-odds of the probability p of a hit against q, by k hits in n trials; p, q in (0, 1),
// 0 <= k <= n.
inline double LogOdds(double k, double n, double p, double q) {
  return k * std::log(p / q) + (n - k) * std::log((1 - p) / (1 - q));
}

}  // namespace gw

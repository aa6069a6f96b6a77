// Evidence of a count: the logarithm of the likelihood ratio of k hits in n trials.
#pragma once

#include <cmath>

namespace gw {

// p against q, the probabilities of a hit; both in (0, 1), 0 <= k <= n.
inline double LogOdds(double k, double n, double p, double q) {
  return k * std::log(p / q) + (n - k) * std::log((1 - p) / (1 - q));
}

}  // namespace gw

// The median of a few numbers.
#pragma once

#include <algorithm>
#include <vector>

#include "common/core/check.h"

namespace gw {

// The value that stands in the middle when they are sorted, the larger of the two of an even count:
// always one of the values. They are put in another order. Precondition: there is one.
template <typename T>
T MedianOf(std::vector<T>* values) {
  GW_CHECK(!values->empty());
  const auto middle = values->begin() + std::ssize(*values) / 2;
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

// Sigma of a normal distribution over the median of its absolute values (1 / 0.6745): for residuals
// with outliers among them.
inline constexpr double kSigmaOverMedian = 1.4826;

}  // namespace gw

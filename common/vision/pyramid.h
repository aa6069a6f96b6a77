// The image pyramid in which features are found: sizes of its levels, and what they say of the
// distance of a landmark.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "common/contract/map.h"

namespace gw {

class Pyramid {
 public:
  static constexpr int kMaxLevels = 32;  // of any message

  // factor > 1: size of a level's pixel in pixels of the level below; 1 <= num_levels <=
  // kMaxLevels.
  Pyramid(double factor, int num_levels)
      : factor_(factor), log_factor_(std::log(factor)), num_levels_(num_levels) {
    for (size_t i = 0; i < scale_.size(); ++i) scale_[i] = std::pow(factor, static_cast<double>(i));
  }

  double factor() const { return factor_; }

  // factor^level: size of the level's pixel, and sigma of a feature found there (px at level 0).
  // 0 <= level < kMaxLevels.
  double Scale(int level) const { return scale_[static_cast<size_t>(level)]; }

  // The farthest distance (m) at which a landmark shows at level 0 or above, when it shows at
  // `level` from `distance`; and the nearest, at which it shows at the highest level.
  double MaxDistance(double distance, int level) const { return distance * Scale(level); }
  double MinDistance(double max_distance) const { return max_distance / Scale(num_levels_ - 1); }

  // The level at which a landmark with this max_distance shows from `distance` > 0.
  int PredictLevel(double max_distance, double distance) const {
    const double level = std::log(max_distance / distance) / log_factor_;
    return static_cast<int>(std::clamp(std::round(level), 0.0, num_levels_ - 1.0));
  }

 private:
  double factor_;
  double log_factor_;
  int num_levels_;
  std::array<double, kMaxLevels> scale_{};
};

}  // namespace gw

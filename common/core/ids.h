// Identities of map elements. Zero means "none".
#pragma once

#include <compare>
#include <cstdint>

namespace gw {

// Counts up from 1 over the life of a map, also across restarts of the front-end.
struct KeyframeId {
  int64_t value = 0;
  constexpr bool valid() const { return value > 0; }
  constexpr auto operator<=>(const KeyframeId&) const = default;
};

// A landmark is named after the keyframe and the feature that created it, so that the front-end
// and the back-end can both create landmarks without asking each other.
struct LandmarkId {
  int64_t value = 0;
  static constexpr int64_t kMaxFeatures = 1 << 14;

  static constexpr LandmarkId From(KeyframeId keyframe, int feature_index) {
    return {keyframe.value * kMaxFeatures + feature_index};
  }
  constexpr bool valid() const { return value > 0; }
  constexpr KeyframeId creator() const { return {value / kMaxFeatures}; }
  constexpr int feature_index() const { return static_cast<int>(value % kMaxFeatures); }
  constexpr auto operator<=>(const LandmarkId&) const = default;
};

}  // namespace gw

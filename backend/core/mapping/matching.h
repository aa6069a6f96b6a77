// Where a landmark should appear in a keyframe, and which feature there shows it.
#pragma once

#include <optional>

#include "backend/core/map/map.h"
#include "backend/core/mapping/mapping_context.h"

namespace gw::backend {

inline constexpr int kMatchHamming = 50;  // of 256 bits; strict, a wrong match costs more than none

// Whether the landmark has an observation in the keyframe.
bool Observes(const Landmark& landmark, KeyframeId keyframe);

struct ExpectedSight {
  Eigen::Vector3d p_C;
  Eigen::Vector2d uv;  // px, in the image
  int level = 0;       // pyramid level at which it should show
};

// Empty when the camera at T_WC should not see it: behind, outside the image, outside its distance
// range (20 % slack), or seen from more than 60 deg off its normal. T_CW = inv(T_WC), both passed
// because callers ask for many landmarks.
std::optional<ExpectedSight> Sight(const MappingContext& context, const Landmark& landmark,
                                   const SE3& T_WC, const SE3& T_CW);

// The feature of the keyframe that shows the landmark: near its expected pixel, at about the
// expected level, within the chi-square gate, closest descriptor of at most kMatchHamming. -1:
// none. `scratch` avoids an allocation per call.
int FindFeature(const MappingContext& context, const Landmark& landmark,
                const ExpectedSight& expected, const MapKeyframe& keyframe,
                std::vector<int>& scratch);

}  // namespace gw::backend

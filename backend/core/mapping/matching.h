// Which feature of a keyframe shows a given landmark.
#pragma once

#include "backend/core/map/map.h"
#include "backend/core/map/mapping_context.h"
#include "common/vision/projection_search.h"

namespace gw::backend {

inline constexpr int kMatchHamming = 50;  // of 256 bits; strict, a wrong match costs more than none

// True when the landmark has an observation in the keyframe.
bool Observes(const Landmark& landmark, KeyframeId keyframe);

// Where the landmark should appear from T_WC: ProjectLandmark with the context's camera.
std::optional<Projection> Project(const MappingContext& context, const Landmark& landmark,
                                  const SE3& T_WC, const SE3& T_CW);

// The feature of the keyframe that shows the landmark: near its expected pixel within the
// chi-square gate, at about the expected level, closest descriptor of at most kMatchHamming. -1:
// none.
int FindFeature(const MappingContext& context, const Landmark& landmark, const Projection& expected,
                const MapKeyframe& keyframe);

}  // namespace gw::backend

// What a keyframe has to hold before the map may take it in. It comes from another process: nothing
// in it is trusted.
#pragma once

#include "common/contract/map.h"
#include "common/vision/pyramid.h"

namespace gw::backend {

enum class KeyframeFault {
  kNone,
  kId,        // not positive, or too large to name landmarks after
  kLengths,   // descriptors or landmarks do not match the features, or too many features
  kPose,      // not finite, or out of reach
  kScale,     // the factor of lengths not between 0.001 and 1000
  kQuality,   // covariance not finite, or q outside [0, 1]
  kLandmark,  // an id out of range
  kFeature,   // a coordinate, depth or level out of range
};

inline constexpr int64_t kMaxKeyframeId = int64_t{1} << 47;  // landmark ids then fit 63 bits
inline constexpr double kMaxCoordinate = 1e6;  // m; farther than any robot of ours drives
inline constexpr int kMaxLevel = Pyramid::kMaxLevels - 1;  // of a feature

// Finite, and within kMaxCoordinate along each axis.
bool IsInReach(const Eigen::Vector3d& p);

// The first fault found.
KeyframeFault CheckKeyframe(const Keyframe& keyframe);
const char* KeyframeFaultText(KeyframeFault fault);

// True when a DR increment can be used as an edge that ends at `utime_end`: finite, covariance
// symmetric with positive diagonal, times in order.
bool IsUsable(const DrIncrement& dr, Utime utime_end);
bool IsUsable(const DrHeight& height);

}  // namespace gw::backend

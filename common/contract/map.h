// What front-end and back-end tell each other about the map. Poses here are of the rectified left
// camera C (see RectifiedCamera); landmarks are points in W.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/contract/dead_reckoning.h"
#include "common/core/ids.h"
#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw {

// 256 binary tests, bit i in word i / 64.
using Descriptor = std::array<uint64_t, 4>;

inline int HammingDistance(const Descriptor& a, const Descriptor& b) {
  return __builtin_popcountll(a[0] ^ b[0]) + __builtin_popcountll(a[1] ^ b[1]) +
         __builtin_popcountll(a[2] ^ b[2]) + __builtin_popcountll(a[3] ^ b[3]);
}

// One feature of an image, in the rectified (undistorted) image.
struct Feature {
  float u = 0, v = 0;  // px
  float u_right = -1;  // px in the (virtual) right image, u - bf / distance; with depth it may be
                       // < 0 at the border
  float depth = -1;    // m along z, within the camera's range; negative = none
  float angle = 0;     // rad, orientation of the patch
  uint8_t level = 0;   // pyramid level; its pixel sigma is scale_factor^level
  bool has_depth() const { return depth > 0; }
  // Also beyond the range in which a depth is good enough to place a landmark.
  bool has_disparity() const { return has_depth() || u_right >= 0; }
};

struct Keyframe {
  KeyframeId id;
  Utime utime;
  SE3 T_WC;  // as tracked, in the map of map_revision
  Matrix6d cov_T_WC = Matrix6d::Zero();
  int64_t map_revision = 0;
  KeyframeId previous;  // the keyframe before in time; invalid for the first
  // The piece of the map that it belongs to, named by the keyframe that began it; invalid: the map
  // itself. How two pieces lie to each other is not known (docs/adr/0047-pieces-of-a-map.md).
  KeyframeId piece;
  // Vision was held by what is not the world: the keyframes of this piece between `previous` and
  // this one leave the map, with what they mapped (docs/adr/0058-void-keyframes.md).
  bool withdraws = false;
  // By which the lengths that the camera tells as it is calibrated were multiplied: they have
  // proven to be wrong. Those of a map that has another factor are to be corrected, in all its
  // pieces (docs/adr/0060-a-wrong-scale-of-vision.md).
  double length_factor = 1;
  static constexpr double kLeastLengthFactor = 1e-3, kMostLengthFactor = 1e3;  // mm for m, m for mm
  std::optional<DrIncrement> dr;  // body motion from `previous` to this one, where DR covers it
  // By DR, where it covers the image.
  std::optional<DrHeight> height;
  double q = 0;  // quality of the frame it was made from
  int32_t num_tracked = 0;
  std::vector<Feature> features;
  std::vector<Descriptor> descriptors;  // one per feature
  // One per feature: the landmark it observes, or an invalid id. A landmark whose creator() is this
  // keyframe is new; it was placed from the feature's depth.
  std::vector<LandmarkId> landmarks;
};

struct Observation {
  KeyframeId keyframe;
  int32_t feature_index = 0;
  auto operator<=>(const Observation&) const = default;
};

struct KeyframeUpdate {
  KeyframeId id;
  Utime utime;
  SE3 T_WC;
  KeyframeId piece{};  // that it belongs to now: pieces are joined
};

// A keyframe that left the map; its pose lives on relative to one that stays.
struct KeyframeRemoval {
  KeyframeId id;
  KeyframeId parent;
  SE3 T_ParentC;
};

// Complete state of a landmark that is new or changed.
struct LandmarkUpdate {
  LandmarkId id;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_W =
      Eigen::Vector3d::Zero();  // mean viewing direction, from the cameras to the point; unit
  float min_distance = 0, max_distance = 0;  // m; where its scale lies inside the pyramid
  Descriptor descriptor{};
  std::vector<Observation> observations;  // sorted
};

struct LandmarkMerge {
  LandmarkId from;  // no longer exists
  LandmarkId into;
};

// A DR edge of the pose graph with the weight that local BA gave it (global BA keeps it).
struct DrEdgeWeight {
  KeyframeId from;
  KeyframeId to;
  double alpha = 0;
};

struct LoopEvent {
  KeyframeId from;
  KeyframeId to;
  bool accepted = false;
  SE3 T_correction;  // W before -> W after, at `from`
};

// A change of the map. Applying the updates in order of revision to the map of base_revision gives
// exactly the back-end's map: replica, journal and viewer all use this one form.
struct MapUpdate {
  Utime utime;  // of the newest keyframe it knows
  int64_t seq = 0;
  int64_t revision = 0;
  int64_t base_revision = 0;
  bool snapshot = false;       // replaces everything the receiver had; base_revision is then 0
  bool frozen = false;         // of a snapshot: the back-end takes in no keyframes, make none
  KeyframeId newest_keyframe;  // newest inserted; ids up to here are taken
  double length_factor = 1;    // of all lengths, as in Keyframe
  std::vector<KeyframeUpdate> keyframes;
  std::vector<KeyframeRemoval> removed_keyframes;
  std::vector<LandmarkUpdate> landmarks;
  std::vector<LandmarkMerge> merged_landmarks;
  std::vector<LandmarkId> removed_landmarks;
  std::vector<DrEdgeWeight> dr_edges;
  std::vector<LoopEvent> loops;
};

// The front-end asks for the map: at start, and when its replica has a gap.
struct MapRequest {
  Utime utime;
  int64_t seq = 0;
  bool has_guess = false;
  SE3 T_WC_guess;  // where it believes to be
};

}  // namespace gw

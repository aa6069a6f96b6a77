// The map as a viewer knows it: what MAP_UPDATE and KEYFRAME messages told since it listens. It
// asks for nothing, so that a viewer that came late has only what changed since, and says so.
#pragma once

#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "common/contract/map.h"

namespace gw::foxglove {

class MapView {
 public:
  struct Loop {
    KeyframeId from, to;
    SE3 T_correction;  // W before -> W after, at `from`
  };
  struct Landmark {
    Eigen::Vector3f p_W;
    int num_observations = 0;
  };
  struct Keyframe {
    SE3 T_WC;
    KeyframeId piece;  // as in KeyframeUpdate; invalid: the map itself
  };

  void Take(const gw::Keyframe& keyframe);
  void Take(const MapUpdate& update);

  // Known from its begin or from a snapshot, without a gap since.
  bool complete() const { return complete_; }
  int64_t revision() const { return revision_; }
  const std::map<KeyframeId, Keyframe>& keyframes() const { return keyframes_; }
  // How many there are beside the map itself (docs/adr/0047-pieces-of-a-map.md).
  size_t num_pieces() const;
  // The keyframe is in a piece whose place in the map is not known.
  bool InPiece(KeyframeId id) const;
  const std::unordered_map<int64_t, Landmark>& landmarks() const { return landmarks_; }
  const std::vector<Loop>& loops() const { return loops_; }  // accepted ones
  std::optional<SE3> KeyframePose(KeyframeId id) const;
  // Keyframes that left the map, expressed in the one that stayed.
  struct Removed {
    KeyframeId parent;
    SE3 T_ParentC;
  };
  // Where a keyframe is now, also one that left the map.
  std::optional<SE3> PoseNow(KeyframeId id) const;

 private:
  bool complete_ = false;
  int64_t revision_ = 0;
  std::map<KeyframeId, Keyframe> keyframes_;
  std::map<KeyframeId, Removed> removed_;
  std::unordered_map<int64_t, Landmark> landmarks_;
  std::vector<Loop> loops_;
};

}  // namespace gw::foxglove

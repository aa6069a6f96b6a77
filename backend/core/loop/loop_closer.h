// Closes loops in the map: detection, pose graph, correction, fusion of what was mapped twice.
//
//   Detect()                          at every new keyframe, at once
//   CutGraph() -> SolveLoopGraph()    plan and solve, the latter on another thread if one likes
//   the owner moves the map, then Settle()   fuses what the loop joined, or takes it back
//
// A pose graph that switches a loop off takes it out of the map: what both of its sides observed is
// parted again. Holds what the map itself does not: the loops, and the index of places.
#pragma once

#include <optional>
#include <vector>

#include "backend/core/loop/loop_detector.h"
#include "backend/core/loop/pose_graph.h"
#include "backend/core/map/map.h"
#include "backend/core/map/mapping_context.h"
#include "backend/core/place/place_index.h"

namespace gw::backend {

struct LoopGraphJob {
  KeyframeId newest;            // of the map it was cut from
  std::vector<KeyframeId> ids;  // of the graph's nodes, sorted
  std::vector<Loop> loops;      // of the graph's groups; the one to close is the last
  PoseGraph graph;
};

struct LoopGraphResult {
  KeyframeId newest;
  std::vector<KeyframeId> ids;
  std::vector<SE3> T_correction;  // one per id: W before -> W after, at that keyframe
  std::vector<Loop> loops;
  PoseGraphResult graph;
  bool closed() const { return graph.usable && graph.group_kept.back() != 0; }
};

LoopGraphResult SolveLoopGraph(const LoopGraphJob& job);

class LoopCloser {
 public:
  explicit LoopCloser(const Map& map);

  // Keeps the index of places in step with the map.
  void File(const Keyframe& keyframe) { places_.Insert(Place{keyframe.id, keyframe.descriptors}); }
  void Forget(KeyframeId id) { places_.Erase(id); }
  const PlaceIndex& places() const { return places_; }

  // Looks for a loop at a keyframe. Not again for a few keyframes after one was closed.
  std::optional<Loop> Detect(const Map& map, const MappingContext& context, KeyframeId at);

  // The pose graph of the map with all loops so far and the new one. Edges: strong covisibility and
  // at least one older neighbour each (the spanning tree), dead reckoning, loops.
  LoopGraphJob CutGraph(const Map& map, const MappingContext& context, const Loop& loop) const;

  // After the keyframes were moved: fuses the new loop's sides and parts those of loops that were
  // switched off. Precondition: result.graph.usable.
  void Settle(Map& map, const MappingContext& context, const LoopGraphResult& result);

  const LoopCounters& counters() const { return counters_; }

 private:
  PlaceIndex places_;
  std::vector<Loop> loops_;
  LoopCounters counters_;
  int64_t rest_until_ = 0;  // keyframe id
};

}  // namespace gw::backend

#include "backend/core/loop/loop_closer.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "backend/core/bundle/connection.h"
#include "backend/core/mapping/fusion.h"
#include "backend/core/mapping/landmark_state.h"
#include "common/core/covariance.h"
#include "common/good_weights/edge_covariance.h"

namespace gw::backend {
namespace {

constexpr int64_t kRest = 5;       // keyframes after a loop before the next is looked for
constexpr int kStrongShared = 60;  // landmarks that make a covisibility edge of the graph
// Keyframes around a loop's end that belong to its side; fewer where the loop is short, so that
// sides do not touch.
constexpr int32_t kSideReach = 15;
int32_t SideReach(int32_t older, int32_t newer) {
  return std::min(kSideReach, (newer - older) / 3);
}

// Spread of the pose of a keyframe against its older neighbours together: their errors are mostly
// the same, so that many neighbours do not make it firmer. So wide that the drift of a chain does
// not switch off the true loop that mends it.
constexpr double kVisualTranslation = 0.02;  // m
constexpr double kVisualRotation = 0.008;    // rad

// Square root of the information of a visual edge, one of `edges` that tie the same keyframe. Their
// errors are the same, so that they share the information of a single one.
Matrix6d VisualSqrtInformation(size_t edges) {
  const double scale = 1.0 / std::sqrt(static_cast<double>(edges));
  Vector6d s;
  s << Eigen::Vector3d::Constant(scale / kVisualTranslation),
      Eigen::Vector3d::Constant(scale / kVisualRotation);
  return s.asDiagonal();
}

// The older keyframes that `id` is tied to by what both see: those with much in common, at least
// one if there is any.
std::vector<KeyframeId> OlderTies(const Map& map, KeyframeId id) {
  std::vector<KeyframeId> out;
  for (const auto& [other, shared] : map.Neighbours(id, 1)) {
    if (other > id) continue;
    if (!out.empty() && shared < kStrongShared) break;
    out.push_back(other);
  }
  return out;
}

// Keeps together what neither vision nor dead reckoning ties: 1 m, 1 rad.
Matrix6d LooseSqrtInformation() {
  return Matrix6d::Identity();
}

using Index = std::map<KeyframeId, int32_t>;

// The loop that a covisibility edge owes its existence to, or -1.
int32_t LoopAcross(const std::vector<Loop>& loops, const Index& index, int32_t a, int32_t b) {
  for (size_t g = 0; g < loops.size(); ++g) {
    const auto older = index.lower_bound(loops[g].older);
    const auto newer = index.lower_bound(loops[g].newer);
    if (older == index.end() || newer == index.end()) continue;
    const int32_t reach = SideReach(older->second, newer->second);
    if (std::abs(a - older->second) <= reach && std::abs(b - newer->second) <= reach) {
      return static_cast<int32_t>(g);
    }
  }
  return -1;
}

// Keyframes around one end of a loop, by order of creation.
std::set<KeyframeId> Side(const Map& map, KeyframeId end, int32_t reach) {
  std::set<KeyframeId> out;
  auto it = map.keyframes().lower_bound(end);
  for (int i = 0; i < reach && it != map.keyframes().begin(); ++i) --it;
  for (int i = 0; i <= 2 * reach && it != map.keyframes().end(); ++i, ++it) out.insert(it->first);
  return out;
}

bool InMap(const Map& map, const Loop& loop) {
  return map.FindKeyframe(loop.older) != nullptr && map.FindKeyframe(loop.newer) != nullptr;
}

// Landmarks that both sides observe keep only their older observations.
void Part(Map& map, const MappingContext& context, const Loop& loop) {
  const auto apart = std::distance(map.keyframes().lower_bound(loop.older),
                                   map.keyframes().lower_bound(loop.newer));
  const int32_t reach = SideReach(0, static_cast<int32_t>(apart));
  const std::set<KeyframeId> older = Side(map, loop.older, reach);
  const std::set<KeyframeId> newer = Side(map, loop.newer, reach);
  std::set<LandmarkId> touched;
  for (const KeyframeId id : newer) {
    const std::vector<LandmarkId> observed = map.FindKeyframe(id)->frame.landmarks;
    for (const LandmarkId landmark : observed) {
      if (!landmark.valid()) continue;
      const auto& observations = map.FindLandmark(landmark)->observations;
      const bool across =
          std::any_of(observations.begin(), observations.end(),
                      [&](const Observation& o) { return older.contains(o.keyframe); });
      if (!across) continue;
      map.RemoveObservation(landmark, id);
      touched.insert(landmark);
    }
  }
  for (const LandmarkId id : touched) {
    RefreshGeometry(map, context, id);
    RefreshDescriptor(map, id);
  }
}

}  // namespace

LoopGraphResult SolveLoopGraph(const LoopGraphJob& job) {
  LoopGraphResult out;
  out.newest = job.newest;
  out.ids = job.ids;
  out.loops = job.loops;
  out.graph = SolvePoseGraph(job.graph);
  if (!out.graph.usable) return out;
  for (size_t i = 0; i < job.ids.size(); ++i) {
    out.T_correction.push_back(out.graph.T_WC[i] * job.graph.nodes[i].T_WC.inverse());
  }
  return out;
}

LoopCloser::LoopCloser(const Map& map) {
  std::vector<Place> places;
  for (const auto& [id, keyframe] : map.keyframes()) {
    places.push_back({id, keyframe.frame.descriptors});
  }
  places_.Insert(places);
}

std::optional<Loop> LoopCloser::Detect(const Map& map, const MappingContext& context,
                                       KeyframeId at) {
  if (at.value < rest_until_) return std::nullopt;
  return DetectLoop(map, context, places_, at, counters_);
}

LoopGraphJob LoopCloser::CutGraph(const Map& map, const MappingContext& context,
                                  const Loop& loop) const {
  LoopGraphJob job;
  job.newest = map.newest_keyframe();
  job.loops = loops_;
  std::erase_if(job.loops, [&](const Loop& l) { return !InMap(map, l); });
  job.loops.push_back(loop);
  Index index;
  const std::map<KeyframeId, KeyframeId> first_of = map.FirstOfPieces();
  for (const auto& [id, keyframe] : map.keyframes()) {
    const auto node = static_cast<int32_t>(job.ids.size());
    index[id] = node;
    job.graph.nodes.push_back({keyframe.frame.T_WC, first_of.at(keyframe.frame.piece) == id});
    job.ids.push_back(id);
  }
  const double reference = ConnectionReference(map, context.dr_weight);
  std::map<KeyframeId, int32_t> newest_of;  // each piece, while walking through the map
  for (const auto& [id, keyframe] : map.keyframes()) {
    const int32_t to = index.at(id);
    const int32_t before =
        std::exchange(newest_of.try_emplace(keyframe.frame.piece, to).first->second, to);
    const std::vector<KeyframeId> ties = OlderTies(map, id);
    for (const KeyframeId other : ties) {
      const int32_t from = index.at(other);
      job.graph.edges.push_back(
          {from, to, map.FindKeyframe(other)->frame.T_WC.inverse() * keyframe.frame.T_WC,
           VisualSqrtInformation(ties.size()), LoopAcross(job.loops, index, from, to)});
    }
    const double alpha = context.dr_weight.Departs(Departure::kPoseGraph)
                             ? DrEdgeScale(map, context, id, reference)
                             : 0.0;
    if (alpha > 0) {
      const DrMotion motion =
          CameraMotion(*keyframe.frame.dr, context.camera.T_BC, context.dr_weight);
      job.graph.edges.push_back(
          {index.at(keyframe.frame.previous), to, motion.T_CaCb,
           SqrtInformation(LoopEdgeCovariance(motion, alpha, context.variant, context.dr_weight)),
           -1});
    } else if (ties.empty() && before != to) {
      job.graph.edges.push_back({before, to,
                                 job.graph.nodes[before].T_WC.inverse() * keyframe.frame.T_WC,
                                 LooseSqrtInformation(), -1});
    }
  }
  for (size_t g = 0; g < job.loops.size(); ++g) {
    const Loop& l = job.loops[g];
    job.graph.edges.push_back({index.at(l.older), index.at(l.newer), l.T_OlderNewer,
                               l.sqrt_information, static_cast<int32_t>(g)});
  }
  job.graph.num_groups = static_cast<int32_t>(job.loops.size());
  return job;
}

void LoopCloser::Settle(Map& map, const MappingContext& context, const LoopGraphResult& result) {
  loops_.clear();
  for (size_t g = 0; g < result.loops.size(); ++g) {
    const Loop& loop = result.loops[g];
    const bool is_new = g + 1 == result.loops.size();
    if (result.graph.group_kept[g] == 0) {
      ++counters_.removed;
      if (!is_new && InMap(map, loop)) Part(map, context, loop);
      continue;
    }
    loops_.push_back(loop);
    loops_.back().matches.clear();
    if (!is_new) continue;
    ++counters_.closed;
    rest_until_ = loop.newer.value + kRest;
    if (!InMap(map, loop)) continue;
    std::vector<std::pair<int32_t, LandmarkId>> matches;
    for (const auto& match : loop.matches) matches.emplace_back(match.feature, match.landmark);
    FuseMatches(map, context, loop.newer, matches);
    FuseGroups(map, context, PlaceGroup(map, loop.newer), PlaceGroup(map, loop.older));
  }
}

}  // namespace gw::backend

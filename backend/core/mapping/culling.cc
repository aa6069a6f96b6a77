#include "backend/core/mapping/culling.h"

#include <algorithm>
#include <iterator>

#include "backend/core/bundle/connection.h"
#include "backend/core/mapping/landmark_state.h"
#include "backend/core/mapping/matching.h"
#include "common/good_weights/quality.h"

namespace gw::backend {
namespace {

// The newest keyframes hold the pose that matters now; their information is spent only when local
// BA has used it several times over.
constexpr size_t kNewest = 10;
constexpr int kFewestToWitness = 30;  // landmarks a keyframe tracks to count as a witness

struct Witness {
  KeyframeId id;
  KeyframeId piece;
  SE3 T_WC;
  SE3 T_CW;
};

bool IsUnproven(const MappingContext& context, const Landmark& landmark, KeyframeId piece,
                const std::vector<Witness>& later, bool last_look) {
  int expected = 0;
  int found = 0;
  for (const Witness& witness : later) {
    if (witness.piece != piece) continue;
    if (Observes(landmark, witness.id)) {
      ++expected;
      ++found;
    } else if (Project(context, landmark, witness.T_WC, witness.T_CW)) {
      ++expected;
    }
  }
  if (expected >= 2 && found < context.config.landmark_min_found_ratio * expected) return true;
  return last_look && expected >= 1 && landmark.observations.size() < 2;
}

bool IsRedundant(const Map& map, const MappingContext& context, const MapKeyframe& keyframe) {
  const auto& f = keyframe.frame;
  const auto enough = static_cast<size_t>(context.config.redundant_observers);
  int close = 0;
  std::vector<std::pair<size_t, const Landmark*>> perhaps;  // by feature
  for (size_t i = 0; i < f.features.size(); ++i) {
    if (!f.landmarks[i].valid() || !f.features[i].has_depth()) continue;
    const Landmark& landmark = *map.FindLandmark(f.landmarks[i]);
    if (landmark.observations.size() < enough) continue;
    ++close;
    if (landmark.observations.size() > enough) perhaps.emplace_back(i, &landmark);
  }
  // Most keyframes are not redundant even if all of these are.
  const double limit = context.config.redundant_share * close;
  if (!(static_cast<double>(perhaps.size()) > limit)) return false;
  int redundant = 0;
  for (const auto& [i, landmark] : perhaps) {
    size_t others = 0;
    for (const Observation& observation : landmark->observations) {
      if (observation.keyframe == f.id) continue;
      const auto& features = map.FindKeyframe(observation.keyframe)->frame.features;
      const size_t index = static_cast<size_t>(observation.feature_index);
      // One level of slack: the same corner is often found on a neighbouring level.
      if (index < features.size() && features[index].level <= f.features[i].level + 1) ++others;
      if (others >= enough) break;
    }
    if (others >= enough) ++redundant;
  }
  return redundant > limit;
}

// True when one DR edge of the keyframe is weak in vision and the other is not.
bool JoinsUnequalEdges(const Map& map, const MappingContext& context, const MapKeyframe& keyframe,
                       double reference) {
  if (!DrInLocalBa(context.variant)) return false;
  const MapKeyframe* next = map.FindKeyframe(keyframe.next);
  if (!keyframe.frame.dr || next == nullptr || !next->frame.dr) return false;
  const auto weak = [&](const MapKeyframe& to) {
    return 1.0 - QualityOfEdge(map, to.frame.id, reference, context.dr_weight) >= kWeakLack;
  };
  return weak(keyframe) != weak(*next);
}

void RemoveRedundant(Map& map, const MappingContext& context, KeyframeId id) {
  const KeyframeId parent = map.Neighbours(id, 1).front().first;
  const std::vector<LandmarkId> observed = map.FindKeyframe(id)->frame.landmarks;
  map.RemoveKeyframe(id, parent);
  for (const LandmarkId landmark : observed) {
    if (!landmark.valid()) continue;
    if (map.FindLandmark(landmark)->observations.size() < 2) {
      map.RemoveLandmark(landmark);
    } else {
      RefreshGeometry(map, context, landmark);
    }
  }
}

}  // namespace

int CullYoungLandmarks(Map& map, const MappingContext& context) {
  std::vector<Witness> later;
  std::vector<LandmarkId> doomed;
  auto it = map.keyframes().rbegin();
  for (int age = 0; age <= kProbation && it != map.keyframes().rend(); ++age, ++it) {
    const MapKeyframe& keyframe = it->second;
    if (age > 0) {
      for (const LandmarkId id : keyframe.frame.landmarks) {
        if (id.creator() != keyframe.frame.id) continue;
        if (IsUnproven(context, *map.FindLandmark(id), keyframe.frame.piece, later,
                       age == kProbation)) {
          doomed.push_back(id);
        }
      }
    }
    if (keyframe.num_observations >= kFewestToWitness) {
      const SE3& T_WC = keyframe.frame.T_WC;
      later.push_back({it->first, keyframe.frame.piece, T_WC, T_WC.inverse()});
    }
  }
  for (const LandmarkId id : doomed) map.RemoveLandmark(id);
  return static_cast<int>(doomed.size());
}

int CullRedundantKeyframes(Map& map, const MappingContext& context) {
  if (map.keyframes().size() <= kNewest + 1) return 0;
  const auto settled = std::next(map.keyframes().rbegin(), kNewest);
  const KeyframeId first = map.FirstOfPieces().at(settled->second.frame.piece);
  std::vector<KeyframeId> candidates;
  if (settled->first != first) candidates.push_back(settled->first);
  const auto& covisible = settled->second.covisible;
  for (auto it = covisible.rbegin(); it != covisible.rend(); ++it) {
    if (it->first < settled->first && it->first != first) candidates.push_back(it->first);
  }
  const double reference = ConnectionReference(map, context.dr_weight);
  int culled = 0;
  for (const KeyframeId id : candidates) {
    const MapKeyframe& keyframe = *map.FindKeyframe(id);
    if (!IsRedundant(map, context, keyframe)) continue;
    if (JoinsUnequalEdges(map, context, keyframe, reference)) continue;
    RemoveRedundant(map, context, id);
    ++culled;
  }
  return culled;
}

}  // namespace gw::backend

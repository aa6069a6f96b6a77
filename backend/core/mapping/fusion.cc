#include "backend/core/mapping/fusion.h"

#include <algorithm>
#include <set>

#include "backend/core/map/seen_landmarks.h"
#include "backend/core/mapping/landmark_state.h"
#include "backend/core/mapping/matching.h"

namespace gw::backend {
namespace {

constexpr size_t kNeighbours = 10;       // covisible with the newest
constexpr size_t kSecondNeighbours = 3;  // of each of these
constexpr size_t kMaxTargets = 20;

std::vector<KeyframeId> Targets(const Map& map) {
  std::vector<KeyframeId> out;
  const KeyframeId newest = map.newest_keyframe();
  const auto add = [&](KeyframeId id) {
    if (id != newest && out.size() < kMaxTargets &&
        std::find(out.begin(), out.end(), id) == out.end()) {
      out.push_back(id);
    }
  };
  for (const auto& [id, shared] : map.Neighbours(newest, 1)) {
    if (out.size() == kNeighbours) break;
    add(id);
  }
  const size_t first = out.size();
  for (size_t i = 0; i < first; ++i) {
    size_t taken = 0;
    for (const auto& [id, shared] : map.Neighbours(out[i], 1)) {
      if (taken++ == kSecondNeighbours) break;
      add(id);
    }
  }
  return out;
}

class Fuser {
 public:
  Fuser(Map& map, const MappingContext& context) : map_(map), context_(context) {}

  void FuseInto(KeyframeId target, const std::vector<LandmarkId>& landmarks) {
    const MapKeyframe& keyframe = *map_.FindKeyframe(target);
    const SE3 T_WC = keyframe.frame.T_WC;
    const SE3 T_CW = T_WC.inverse();
    for (const LandmarkId id : landmarks) {
      const Landmark* landmark = map_.FindLandmark(id);
      if (landmark == nullptr || Observes(*landmark, target)) continue;
      const auto expected = Project(context_, *landmark, T_WC, T_CW);
      if (!expected) continue;
      const int feature = FindFeature(context_, *landmark, *expected, keyframe);
      if (feature >= 0) Join(id, {target, feature});
    }
  }

  // The feature shows the landmark.
  void Join(LandmarkId id, const Observation& observation) {
    const LandmarkId other =
        map_.FindKeyframe(observation.keyframe)->frame.landmarks[observation.feature_index];
    if (other.valid()) {
      if (other != id) Merge(id, other);
    } else if (map_.AddObservation(id, observation)) {
      ++counts_.observations;
      changed_.insert(id);
    }
  }

  FusionCounts Finish() {
    for (const LandmarkId id : changed_) {
      if (map_.FindLandmark(id) == nullptr) continue;
      RefreshGeometry(map_, context_, id);
      RefreshDescriptor(map_, id);
    }
    return counts_;
  }

 private:
  void Merge(LandmarkId a, LandmarkId b) {
    const size_t seen_a = map_.FindLandmark(a)->observations.size();
    const size_t seen_b = map_.FindLandmark(b)->observations.size();
    const bool keep_a = seen_a != seen_b ? seen_a > seen_b : a < b;
    const LandmarkId into = keep_a ? a : b;
    map_.MergeLandmark(keep_a ? b : a, into);
    changed_.insert(into);
    ++counts_.merged;
  }

  Map& map_;
  const MappingContext& context_;
  FusionCounts counts_;
  std::set<LandmarkId> changed_;
};

}  // namespace

FusionCounts FuseWithNeighbours(Map& map, const MappingContext& context) {
  const KeyframeId newest = map.newest_keyframe();
  const std::vector<KeyframeId> targets = Targets(map);
  Fuser fuser(map, context);
  const std::vector<LandmarkId> own = SeenLandmarks(map, std::vector{newest});
  for (const KeyframeId target : targets) fuser.FuseInto(target, own);
  fuser.FuseInto(newest, SeenLandmarks(map, targets));
  return fuser.Finish();
}

FusionCounts FuseMatches(Map& map, const MappingContext& context, KeyframeId keyframe,
                         const std::vector<std::pair<int32_t, LandmarkId>>& matches) {
  Fuser fuser(map, context);
  for (const auto& [feature, named] : matches) {
    const LandmarkId id = map.Resolve(named);
    if (id.valid() && !Observes(*map.FindLandmark(id), keyframe)) {
      fuser.Join(id, {keyframe, feature});
    }
  }
  return fuser.Finish();
}

FusionCounts FuseGroups(Map& map, const MappingContext& context, const std::vector<KeyframeId>& a,
                        const std::vector<KeyframeId>& b) {
  Fuser fuser(map, context);
  const std::vector<LandmarkId> of_a = SeenLandmarks(map, a);
  for (const KeyframeId id : b) fuser.FuseInto(id, of_a);
  const std::vector<LandmarkId> of_b = SeenLandmarks(map, b);
  for (const KeyframeId id : a) fuser.FuseInto(id, of_b);
  return fuser.Finish();
}

}  // namespace gw::backend

#include "backend/core/map/map_check.h"

#include <algorithm>
#include <map>
#include <utility>

#include "backend/core/map/keyframe_check.h"

namespace gw::backend {
namespace {

class Checker {
 public:
  explicit Checker(const Map& map) : map_(map) {}

  MapFaults Run() {
    for (const auto& [id, keyframe] : map_.keyframes()) CheckKeyframe(id, keyframe);
    for (const LandmarkId id : map_.SortedLandmarkIds()) CheckLandmark(*map_.FindLandmark(id));
    for (const auto& [id, keyframe] : map_.keyframes()) CheckCounts(id, keyframe);
    const MapUpdate whole = map_.Snapshot();
    for (const KeyframeRemoval& removal : whole.removed_keyframes) {
      if (map_.FindKeyframe(removal.id) != nullptr) Fault(removal.id, "is removed and there");
      if (map_.FindKeyframe(removal.parent) == nullptr) {
        Fault(removal.id, "was removed and lives on in one that is not there");
      }
    }
    for (const LandmarkMerge& merge : whole.merged_landmarks) {
      if (map_.FindLandmark(merge.from) != nullptr) Fault(merge.from, "is merged and there");
    }
    return std::move(faults_);
  }

 private:
  void Fault(const std::string& what) {
    ++faults_.count;
    if (faults_.texts.size() < MapFaults::kMaxTexts) faults_.texts.push_back(what);
  }
  void Fault(KeyframeId id, const std::string& what) {
    Fault("keyframe " + std::to_string(id.value) + " " + what);
  }
  void Fault(LandmarkId id, const std::string& what) {
    Fault("landmark " + std::to_string(id.value) + " " + what);
  }

  void CheckKeyframe(KeyframeId id, const MapKeyframe& keyframe) {
    const Keyframe& f = keyframe.frame;
    if (id != f.id || id > map_.newest_keyframe()) Fault(id, "has an id that is not its own");
    if (const KeyframeFault fault = backend::CheckKeyframe(f); fault != KeyframeFault::kNone) {
      Fault(id, std::string("is not plausible: ") + KeyframeFaultText(fault));
    }
    CheckChain(id, keyframe);
    for (size_t i = 0; i < f.landmarks.size(); ++i) {
      if (!f.landmarks[i].valid()) continue;
      const Landmark* landmark = map_.FindLandmark(f.landmarks[i]);
      const Observation own{id, static_cast<int32_t>(i)};
      if (landmark == nullptr ||
          !std::binary_search(landmark->observations.begin(), landmark->observations.end(), own)) {
        Fault(id, "has a feature of a landmark that does not know it");
      }
      const std::pair<LandmarkId, int32_t> seen{f.landmarks[i], own.feature_index};
      if (!std::binary_search(keyframe.seen.begin(), keyframe.seen.end(), seen)) {
        Fault(id, "does not list a landmark that it observes");
      }
    }
  }

  void CheckChain(KeyframeId id, const MapKeyframe& keyframe) {
    const Keyframe& f = keyframe.frame;
    const MapKeyframe* next = map_.FindKeyframe(keyframe.next);
    if (keyframe.next.valid() && (next == nullptr || next->frame.previous != id)) {
      Fault(id, "is followed by one that does not follow it");
    }
    if (!f.previous.valid()) {
      if (f.dr) Fault(id, "has a DR increment from nowhere");
      return;
    }
    const MapKeyframe* previous = map_.FindKeyframe(f.previous);
    if (previous == nullptr || previous->next != id) {
      Fault(id, "follows one that does not lead to it");
    } else if (previous->frame.utime >= f.utime) {
      Fault(id, "is not later than the one before it");
    } else if (previous->frame.piece != f.piece) {
      Fault(id, "follows one of another piece");
    }
    if (!(keyframe.dr_alpha >= 0)) Fault(id, "has a negative DR weight");
  }

  void CheckLandmark(const Landmark& landmark) {
    if (!IsInReach(landmark.p_W) || !landmark.normal_W.allFinite()) {
      Fault(landmark.id, "is not at a plausible place");
    }
    if (landmark.id.creator() > map_.newest_keyframe()) {
      Fault(landmark.id, "is named after a keyframe that is yet to come");
    }
    if (landmark.observations.empty()) Fault(landmark.id, "is observed by no keyframe");
    for (size_t i = 0; i < landmark.observations.size(); ++i) {
      const Observation& o = landmark.observations[i];
      const MapKeyframe* keyframe = map_.FindKeyframe(o.keyframe);
      const auto index = static_cast<size_t>(o.feature_index);
      if (i > 0 && o.keyframe <= landmark.observations[i - 1].keyframe) {
        Fault(landmark.id, "has observations that are not sorted or not unique");
      }
      if (keyframe == nullptr || index >= keyframe->frame.landmarks.size() ||
          keyframe->frame.landmarks[index] != landmark.id) {
        Fault(landmark.id, "is observed by a feature that does not know it");
        continue;
      }
      const MapKeyframe* first = map_.FindKeyframe(landmark.observations.front().keyframe);
      if (first != nullptr && keyframe->frame.piece != first->frame.piece) {
        Fault(landmark.id, "is observed from two pieces");
      }
      ++num_observations_[o.keyframe];
      for (size_t j = 0; j < i; ++j) ++shared_[o.keyframe][landmark.observations[j].keyframe];
      for (size_t j = 0; j < i; ++j) ++shared_[landmark.observations[j].keyframe][o.keyframe];
    }
  }

  void CheckCounts(KeyframeId id, const MapKeyframe& keyframe) {
    if (keyframe.num_observations != num_observations_[id] ||
        std::cmp_not_equal(keyframe.seen.size(), num_observations_[id])) {
      Fault(id, "has a wrong count of observations");
    }
    const std::map<KeyframeId, int32_t>& shared = shared_[id];
    if (!std::equal(keyframe.covisible.begin(), keyframe.covisible.end(), shared.begin(),
                    shared.end(), [](const auto& a, const auto& b) {
                      return a.first == b.first && a.second == b.second;
                    })) {
      Fault(id, "has covisible keyframes that its landmarks do not tell");
    }
  }

  const Map& map_;
  MapFaults faults_;
  std::map<KeyframeId, int32_t> num_observations_;
  std::map<KeyframeId, std::map<KeyframeId, int32_t>> shared_;
};

}  // namespace

MapFaults CheckMap(const Map& map) {
  return Checker(map).Run();
}

}  // namespace gw::backend

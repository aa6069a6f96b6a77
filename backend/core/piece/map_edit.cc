#include "backend/core/piece/map_edit.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "common/core/check.h"

namespace gw::backend {
namespace {

// A map, as the keyframes and the snapshot that make it.
struct Content {
  std::vector<Keyframe> keyframes;  // sorted by id
  MapUpdate state;
};

Content ContentOf(const Map& map) {
  Content out;
  for (const auto& [id, keyframe] : map.keyframes()) out.keyframes.push_back(keyframe.frame);
  out.state = map.Snapshot();
  return out;
}

Map MapOf(const Content& content) {
  Map map;
  for (const Keyframe& keyframe : content.keyframes) GW_CHECK(map.AddKeyframe(keyframe));
  const Map::Applied applied = map.Apply(content.state);
  GW_CHECK(applied == Map::Applied::kDone && map.num_ignored() == 0);
  return map;
}

void Renumber(int64_t by, KeyframeId* id) {
  if (id->valid()) id->value += by;
}

void Renumber(int64_t by, LandmarkId* id) {
  if (id->valid()) *id = LandmarkId::From({id->creator().value + by}, id->feature_index());
}

void Renumber(int64_t by, Content* content) {
  for (Keyframe& keyframe : content->keyframes) {
    Renumber(by, &keyframe.id);
    Renumber(by, &keyframe.previous);
    Renumber(by, &keyframe.piece);
    for (LandmarkId& landmark : keyframe.landmarks) Renumber(by, &landmark);
  }
  MapUpdate& state = content->state;
  Renumber(by, &state.newest_keyframe);
  for (KeyframeUpdate& keyframe : state.keyframes) {
    Renumber(by, &keyframe.id);
    Renumber(by, &keyframe.piece);
  }
  for (KeyframeRemoval& removal : state.removed_keyframes) {
    Renumber(by, &removal.id);
    Renumber(by, &removal.parent);
  }
  for (LandmarkUpdate& landmark : state.landmarks) {
    Renumber(by, &landmark.id);
    for (Observation& observation : landmark.observations) Renumber(by, &observation.keyframe);
  }
  for (LandmarkMerge& merge : state.merged_landmarks) {
    Renumber(by, &merge.from);
    Renumber(by, &merge.into);
  }
  for (DrEdgeWeight& edge : state.dr_edges) {
    Renumber(by, &edge.from);
    Renumber(by, &edge.to);
  }
}

// The map itself becomes a piece, named by its first keyframe.
void MakePiece(Content* content) {
  const auto begin = std::find_if(content->keyframes.begin(), content->keyframes.end(),
                                  [](const Keyframe& keyframe) { return !keyframe.piece.valid(); });
  if (begin == content->keyframes.end()) return;
  const KeyframeId piece = begin->id;
  for (Keyframe& keyframe : content->keyframes) {
    if (!keyframe.piece.valid()) keyframe.piece = piece;
  }
  for (KeyframeUpdate& keyframe : content->state.keyframes) {
    if (!keyframe.piece.valid()) keyframe.piece = piece;
  }
}

template <typename T>
void Append(const std::vector<T>& from, std::vector<T>* to) {
  to->insert(to->end(), from.begin(), from.end());
}

}  // namespace

Map KeepKeyframes(const Map& map, const std::function<bool(const MapKeyframe&)>& keep) {
  std::vector<KeyframeId> gone;
  KeyframeId stays;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (keep(keyframe)) {
      stays = id;
    } else {
      gone.push_back(id);
    }
  }
  if (!stays.valid()) return {};
  Map kept = map;
  for (const KeyframeId id : gone) kept.RemoveKeyframe(id, stays);
  for (const LandmarkId id : kept.SortedLandmarkIds()) {
    if (kept.FindLandmark(id)->observations.empty()) kept.RemoveLandmark(id);
  }
  kept.Commit();
  Content content = ContentOf(kept);
  content.state.removed_keyframes.clear();
  content.state.merged_landmarks.clear();
  return MapOf(content);
}

Map PutTogether(const Map& a, const Map& b) {
  // One of the same camera: where its lengths were found to be wrong, they are so in both.
  Map in_lengths_of_a = b;
  if (a.length_factor() != b.length_factor()) {
    in_lengths_of_a.SetLengthFactor(a.length_factor());
    in_lengths_of_a.Commit();
  }
  Content both = ContentOf(a);
  Content of_b = ContentOf(in_lengths_of_a);
  Renumber(a.newest_keyframe().value, &of_b);
  MakePiece(&of_b);
  Append(of_b.keyframes, &both.keyframes);
  both.state.utime = of_b.state.utime;
  both.state.revision = std::max(both.state.revision, of_b.state.revision);
  both.state.newest_keyframe = of_b.state.newest_keyframe;
  Append(of_b.state.keyframes, &both.state.keyframes);
  Append(of_b.state.landmarks, &both.state.landmarks);
  Append(of_b.state.removed_keyframes, &both.state.removed_keyframes);
  Append(of_b.state.merged_landmarks, &both.state.merged_landmarks);
  Append(of_b.state.dr_edges, &both.state.dr_edges);
  return MapOf(both);
}

}  // namespace gw::backend

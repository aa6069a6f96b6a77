#include "backend/core/piece/merge_maps.h"

#include <set>
#include <vector>

#include "backend/core/mapper.h"
#include "backend/core/piece/map_edit.h"

namespace gw::backend {
namespace {

std::vector<KeyframeId> KeyframesAfter(const Map& map, KeyframeId id) {
  std::vector<KeyframeId> out;
  for (auto it = map.keyframes().upper_bound(id); it != map.keyframes().end(); ++it) {
    out.push_back(it->first);
  }
  return out;
}

// Keyframes after `newest_of_a` that lie in a piece of those before.
int CountJoined(const Map& map, KeyframeId newest_of_a) {
  std::set<KeyframeId> pieces;
  int joined = 0;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (id <= newest_of_a) {
      pieces.insert(keyframe.frame.piece);
    } else {
      joined += pieces.contains(keyframe.frame.piece) ? 1 : 0;
    }
  }
  return joined;
}

int CloseLoops(const std::vector<KeyframeId>& keyframes, Mapper* mapper) {
  int closed = 0;
  for (const KeyframeId id : keyframes) {
    const auto job = mapper->CloseLoopAt(id);
    if (!job) continue;
    const LoopGraphResult result = SolveLoopGraph(*job);
    if (mapper->Apply(result) && result.closed()) ++closed;
  }
  return closed;
}

}  // namespace

Result<MergedMap> MergeMaps(const Map& a, const Map& b, const BackendConfig& config,
                            const FrontendConfig& frontend, const RectifiedCamera& camera) {
  auto mapper = Mapper::Create(config, frontend, camera, PutTogether(a, b));
  if (!mapper) return mapper.error();
  const std::vector<KeyframeId> of_b = KeyframesAfter(mapper->map(), a.newest_keyframe());
  for (const KeyframeId id : of_b) mapper->JoinPiecesAt(id);
  MergedMap out;
  out.keyframes_joined = CountJoined(mapper->map(), a.newest_keyframe());
  if (out.keyframes_joined == 0) {
    return Error{ErrorCode::kNotFound,
                 "the maps show no place in common that several keyframes agree on"};
  }
  out.loops = CloseLoops(of_b, &*mapper);
  if (const auto job = mapper->BuildGlobalJob()) mapper->ApplyGlobal(SolveLocalBa(*job));
  out.map = mapper->map();
  return out;
}

}  // namespace gw::backend

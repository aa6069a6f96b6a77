#include "backend/core/merge_maps.h"

#include <algorithm>
#include <deque>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "backend/core/mapper.h"
#include "backend/core/piece/map_edit.h"

namespace gw::backend {
namespace {

// Keyframes less apart than this tell the same.
constexpr double kSampleWay = 0.25;  // m
constexpr double kSampleTurn = 10.0 * std::numbers::pi / 180;
// Two cameras so near to each other see the same, and each is located by what the other saw.
constexpr double kSameViewWay = 0.3;  // m
constexpr double kSameViewTurn = 10.0 * std::numbers::pi / 180;
// So many views in a row that are not what they should be are another place
// (docs/adr/0048-merging-maps.md).
constexpr int kUnlikeInARow = 6;

bool Near(const SE3& a, const SE3& b, double way, double turn) {
  const SE3 apart = a.inverse() * b;
  return apart.translation().norm() < way && LogSO3(apart.rotation()).norm() < turn;
}

std::vector<KeyframeId> KeyframesAfter(const Map& map, KeyframeId id) {
  std::vector<KeyframeId> out;
  for (auto it = map.keyframes().upper_bound(id); it != map.keyframes().end(); ++it) {
    out.push_back(it->first);
  }
  return out;
}

// Those that lie apart from the one before.
std::vector<KeyframeId> Sample(const Map& map, const std::vector<KeyframeId>& keyframes) {
  std::vector<KeyframeId> out;
  for (const KeyframeId id : keyframes) {
    if (out.empty() || !Near(map.FindKeyframe(out.back())->frame.T_WC,
                             map.FindKeyframe(id)->frame.T_WC, kSampleWay, kSampleTurn)) {
      out.push_back(id);
    }
  }
  return out;
}

// Is the keyframe one of those that agree in the join?
bool HasSight(const PieceJoin& join, KeyframeId keyframe) {
  return std::any_of(join.sights.begin(), join.sights.end(),
                     [&](const PieceSight& sight) { return sight.keyframe == keyframe; });
}

// The join that most sights agree in.
std::optional<PieceJoin> BestJoin(const Map& map, const std::deque<PieceSight>& sights) {
  std::optional<PieceJoin> best;
  for (const PieceSight& sight : sights) {
    auto join = Agreeing(map, sight, sights);
    if (!best || join.sights.size() > best->sights.size()) best = std::move(join);
  }
  if (!best || best->sights.size() < kAgreeingSights) return std::nullopt;
  return best;
}

// Longest run of keyframes that a join puts where the other piece has a view, but that do not show
// it. What is alike in two places is told by what surrounds it.
int UnlikeInARow(const Map& map, const PieceJoin& join, const std::vector<KeyframeId>& keyframes) {
  int longest = 0, run = 0;
  for (const KeyframeId id : keyframes) {
    const Keyframe& keyframe = map.FindKeyframe(id)->frame;
    if (keyframe.piece != join.from) continue;
    if (HasSight(join, id)) {
      run = 0;
      continue;
    }
    const SE3 T_IntoC = join.T_IntoFrom * keyframe.T_WC;
    const bool should =
        std::any_of(map.keyframes().begin(), map.keyframes().end(), [&](const auto& entry) {
          return entry.second.frame.piece == join.into &&
                 Near(T_IntoC, entry.second.frame.T_WC, kSameViewWay, kSameViewTurn);
        });
    run += should ? 1 : 0;
    longest = std::max(longest, run);
  }
  return longest;
}

// How the second map lies in the first, or why that is not told.
Result<PieceJoin> FindJoin(const Mapper& mapper, const std::vector<KeyframeId>& keyframes) {
  const Map& map = mapper.map();
  std::deque<PieceSight> sights;
  for (const KeyframeId id : keyframes) {
    if (auto sight = mapper.SeeElsewhere(id)) sights.push_back(*std::move(sight));
  }
  const auto join = BestJoin(map, sights);
  if (!join) {
    return Error{ErrorCode::kNotFound,
                 "the maps show no place in common that several keyframes agree on (" +
                     std::to_string(sights.size()) + " of " + std::to_string(keyframes.size()) +
                     " views are located)"};
  }
  std::erase_if(sights, [&](const PieceSight& s) { return HasSight(*join, s.keyframe); });
  if (const auto rival = BestJoin(map, sights)) {
    return Error{ErrorCode::kNotFound,
                 "the maps look alike in two ways: " + std::to_string(join->sights.size()) +
                     " views say one, " + std::to_string(rival->sights.size()) + " another"};
  }
  const int unlike = UnlikeInARow(map, *join, keyframes);
  if (unlike >= kUnlikeInARow) {
    return Error{ErrorCode::kNotFound, "the maps look alike, but are not of one place: " +
                                           std::to_string(join->sights.size()) +
                                           " views agree, but " + std::to_string(unlike) +
                                           " in a row do not show what they should"};
  }
  return *join;
}

int CloseLoops(const std::vector<KeyframeId>& keyframes, Mapper* mapper) {
  int closed = 0;
  for (const KeyframeId id : keyframes) {
    if (mapper->map().FindKeyframe(id) == nullptr) continue;
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
  const std::vector<KeyframeId> sample = Sample(mapper->map(), of_b);
  const auto join = FindJoin(*mapper, sample);
  if (!join) return join.error();
  MergedMap out;
  out.views = static_cast<int>(join->sights.size());
  mapper->Join(*join);
  out.loops = CloseLoops(sample, &*mapper);
  if (const auto job = mapper->BuildGlobalJob()) mapper->ApplyGlobal(SolveLocalBa(*job));
  out.map = mapper->map();
  return out;
}

}  // namespace gw::backend

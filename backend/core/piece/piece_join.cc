#include "backend/core/piece/piece_join.h"

#include <algorithm>
#include <utility>

#include "common/vision/same_place.h"

namespace gw::backend {
namespace {

// What a sight says of its two pieces. The frame of the map itself stays, else of the older piece.
struct Claim {
  KeyframeId into, from;
  SE3 T_IntoFrom;
  SE3 T_FromC;  // camera of the end that lies in `from`
};

Claim ClaimOf(const Map& map, const PieceSight& sight) {
  const Keyframe& keyframe = map.FindKeyframe(sight.keyframe)->frame;
  const Keyframe& place = map.FindKeyframe(sight.place)->frame;
  const SE3 T_PlacesKeyframe = place.T_WC * sight.T_PlaceKeyframe * keyframe.T_WC.inverse();
  if (place.piece < keyframe.piece) {
    return {place.piece, keyframe.piece, T_PlacesKeyframe, keyframe.T_WC};
  }
  return {keyframe.piece, place.piece, T_PlacesKeyframe.inverse(), place.T_WC};
}

bool SamePieces(const Claim& a, const Claim& b) {
  return a.into == b.into && a.from == b.from;
}

bool Agree(const Claim& a, const Claim& b) {
  const SE3 error = (a.T_IntoFrom * b.T_FromC).inverse() * (b.T_IntoFrom * b.T_FromC);
  return SamePlace(error, (a.T_FromC.inverse() * b.T_FromC).translation().norm());
}

}  // namespace

std::optional<PieceSight> SeeElsewhere(const Map& map, const MappingContext& context,
                                       const PlaceIndex& places, KeyframeId keyframe) {
  const MapKeyframe& image = *map.FindKeyframe(keyframe);
  const auto located =
      LocateImage(map, context, places, image, static_cast<uint64_t>(keyframe.value),
                  [&](KeyframeId id) { return map.PieceOf(id) != image.frame.piece; });
  if (!located) return std::nullopt;
  const SE3 T_WPlace = map.FindKeyframe(located->place)->frame.T_WC;
  return PieceSight{keyframe, located->place, T_WPlace.inverse() * located->fit.T_WC,
                    located->fit.matches};
}

PieceJoin Agreeing(const Map& map, const PieceSight& sight, const std::deque<PieceSight>& sights,
                   size_t* contradicting) {
  const Claim claimed = ClaimOf(map, sight);
  PieceJoin join{claimed.into, claimed.from, claimed.T_IntoFrom, {}};
  size_t others = 0;
  for (const PieceSight& other : sights) {
    const Claim claim = ClaimOf(map, other);
    if (!SamePieces(claim, claimed)) continue;
    if (Agree(claim, claimed)) {
      join.sights.push_back(other);
    } else {
      ++others;
    }
  }
  if (contradicting != nullptr) *contradicting = others;
  return join;
}

std::optional<PieceJoin> PieceJoiner::Consider(const Map& map, const MappingContext& context,
                                               const PlaceIndex& places, KeyframeId keyframe) {
  std::erase_if(sights_, [&](const PieceSight& sight) {
    return map.FindKeyframe(sight.keyframe) == nullptr ||
           map.FindKeyframe(sight.place) == nullptr ||
           map.PieceOf(sight.keyframe) == map.PieceOf(sight.place);
  });
  auto sight = SeeElsewhere(map, context, places, keyframe);
  if (!sight) return std::nullopt;
  sights_.push_back(*std::move(sight));
  if (sights_.size() > kMemory) sights_.pop_front();
  size_t contradicting = 0;
  PieceJoin join = Agreeing(map, sights_.back(), sights_, &contradicting);
  if (join.sights.size() < kAgreeingSights + contradicting) return std::nullopt;
  return join;
}

}  // namespace gw::backend

// Two pieces of a map show the same place: how do they lie to each other?
//
// Dead reckoning leads from no piece to another, so it cannot testify; the evidence is that of
// vision over several keyframes, as for place answers of the front-end
// (docs/adr/0009-loops-and-relocalisation.md): keyframes of the one that are located in the other,
// each all around its image and without a rival, and that put the one piece at the same place in
// the other although they were taken along a way. A look-alike does not keep that up.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "backend/core/loop/locate.h"
#include "backend/core/map/map.h"
#include "backend/core/map/mapping_context.h"
#include "backend/core/place/place_index.h"

namespace gw::backend {

// A keyframe that shows a place of another piece.
struct PieceSight {
  KeyframeId keyframe;
  KeyframeId place;  // the keyframe of the other piece that looks most like it
  SE3 T_PlaceKeyframe;
  std::vector<PlaceFit::Match> matches;  // features of `keyframe`, landmarks of the other piece
};

struct PieceJoin {
  KeyframeId into, from;  // the piece that stays (the map itself, or the older), and the other
  SE3 T_IntoFrom;         // the frame of the one in that of the other
  std::vector<PieceSight> sights;  // that agree in it, newest last
};

// Is the keyframe located in another piece?
std::optional<PieceSight> SeeElsewhere(const Map& map, const MappingContext& context,
                                       const PlaceIndex& places, KeyframeId keyframe);

// Sights that say how two pieces lie to each other have to be so many; each that says otherwise
// asks for one more.
inline constexpr size_t kAgreeingSights = 3;

// What `sight` says of its two pieces, with those of `sights` that agree.
// contradicting: how many say otherwise of the same two; may be null.
PieceJoin Agreeing(const Map& map, const PieceSight& sight, const std::deque<PieceSight>& sights,
                   size_t* contradicting = nullptr);

// Live: asks of every new keyframe.
class PieceJoiner {
 public:
  static constexpr size_t kMemory = 12;  // newest sights

  // `keyframe` is newer than those asked about before. With those, it may tell how two pieces lie
  // to each other.
  std::optional<PieceJoin> Consider(const Map& map, const MappingContext& context,
                                    const PlaceIndex& places, KeyframeId keyframe);

 private:
  std::deque<PieceSight> sights_;
};

}  // namespace gw::backend

// What the tracker knows of its place, and what it says of an image: the states of the front-end,
// their one transition, and the one place where the published status is decided.
#pragma once

#include "common/contract/tracking.h"

namespace gw::frontend {

enum class TrackingState {
  kStart,     // no image yet
  kUnplaced,  // the pose refers to the start of this process, not to the map
  kBlind,     // the pose refers to the map; dead reckoning or extrapolation carried the last image
  kTracking,  // the pose refers to the map; vision carried the last image
};

inline bool IsPlaced(TrackingState state) {
  return state == TrackingState::kBlind || state == TrackingState::kTracking;
}

// What became of one image.
struct ImageOutcome {
  bool map_there = false;      // there are landmarks to be tracked
  bool begins_map = false;     // there was no map, and this image begins one
  bool begins_piece = false;   // where in the map is not known, and this image begins a piece of it
  bool vision = false;         // a pose from vision was believed
  bool unconfirmed = false;    // vision found a pose that is not believed yet
  bool from_dr = false;        // dead reckoning covers the motion since the image before
  bool corrected = false;      // vision is back, and moved the pose noticeably
  bool place_known = true;     // the pose may be claimed: the place is known and not in doubt
  bool contradicted = false;   // the witnesses disagree for good: one of them is wrong
  bool time_reversed = false;  // the image is not newer than the one before; not used
  double q = 0;                // quality of tracking, [0, 1]
  double dr_share = 0;         // of dead reckoning in the information of the pose, [0, 1]
};

// After the image.
TrackingState NextState(TrackingState before, const ImageOutcome& outcome);

// Published with the image; `before`: the state before it.
TrackingStatus StatusOf(TrackingState before, const ImageOutcome& outcome);

}  // namespace gw::frontend

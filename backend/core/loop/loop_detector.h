// Has a keyframe, as a rule the newest, been taken where the robot was before, without the map
// knowing it?
//
//   candidates (look alike, or near within the drift of dead reckoning) -> geometric fit -> the
//   keyframes just before agree -> dead reckoning does not contradict
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "backend/core/loop/place_fit.h"
#include "backend/core/map/map.h"
#include "backend/core/map/mapping_context.h"
#include "backend/core/place/place_index.h"
#include "common/core/chi_square.h"

namespace gw::backend {

struct Loop {
  KeyframeId older, newer;
  SE3 T_OlderNewer;  // camera poses
  Matrix6d sqrt_information = Matrix6d::Identity();
  // What `newer` sees of the older part: to be fused once the poses agree.
  std::vector<PlaceFit::Match> matches;
};

struct LoopCounters {
  int64_t candidates = 0;     // keyframes that a newest one was compared with
  int64_t fits = 0;           // of these, geometry agreed
  int64_t inconsistent = 0;   // fits that the keyframes before did not share
  int64_t refused_by_dr = 0;  // loops that contradict the drift bound of dead reckoning
  int64_t closed = 0;         // that went into the map
  int64_t removed = 0;        // found wrong by the pose graph, at once or later
};

// Motion of the camera by dead reckoning from `older` to `newer` along the temporal chain, with the
// covariance of its drift (nominal or the filter's, whichever is larger). Empty when the chain is
// broken between them.
struct DrChain {
  SE3 T_OlderNewer;
  Matrix6d cov = Matrix6d::Zero();  // right perturbation
};
std::optional<DrChain> ChainDr(const Map& map, const MappingContext& context, KeyframeId older,
                               KeyframeId newer);

// Squared Mahalanobis distance between what the loop and what dead reckoning say (6 degrees of
// freedom). Above kDrGate (99.9 %) the loop is refused.
inline constexpr double kDrGate = kChi2Six999;
double DrContradiction(const DrChain& chain, const SE3& T_OlderNewer, const Matrix6d& cov_loop);

// Looks for a loop from keyframe `at` to an older one of its piece. `places` has the map's
// keyframes filed.
std::optional<Loop> DetectLoop(const Map& map, const MappingContext& context,
                               const PlaceIndex& places, KeyframeId at, LoopCounters& counters);

}  // namespace gw::backend

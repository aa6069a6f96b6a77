// C_ref and the smoothing of the weights as they are printed in Du, Peng, Vela, "Good Weights",
// arXiv 2509.22910, section III-C, "Local Bundle Adjustment". What the text leaves open is read as
// docs/method.md, section 3.9 says.
#pragma once

#include <functional>

#include "backend/core/map/map.h"
#include "common/config/dr_weight_config.h"

namespace gw::backend {

// "The median connection count from well-tracked keyframes in the most recent covisibility graph":
// median of `connection` over the well tracked keyframes (num_tracked >= n_trk_ref) with a
// predecessor, among the newest of them and its covisible neighbours. 20 while there is none.
double PaperConnectionReference(const Map& map, const DrWeightConfig& config,
                                const std::function<double(const MapKeyframe&)>& connection);

// "A windowed smoothing strategy distributes DR weights to adjacent keyframes. The weighting
// decreases with covisibility distance": weighted mean of alpha over the keyframes at most 3 before
// and after `centre` in time, weight 2^-d at d hops in the graph of covisibility and temporal
// order. lack: 1 - Q_ij of the edge that ends at a keyframe; keyframes without an edge have no
// alpha to distribute. The result is a lack of quality again, that of the mean alpha.
double PaperSmoothedLack(const Map& map, const MapKeyframe& centre, const DrWeightConfig& config,
                         const std::function<double(const MapKeyframe&)>& lack);

}  // namespace gw::backend

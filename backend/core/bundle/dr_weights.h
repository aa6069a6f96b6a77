// Good Weights in local mapping: how strongly the DR edge between temporally adjacent keyframes
// counts (method.md section 3).
//
//   Q_ij = min(clip(C_ij / C_ref, 0, 1), Q_j)           C_ij: close landmarks that both observe
//   alpha = alpha_min * (alpha_max / alpha_min)^(1-Q)
//
// Q_j, the front-end's quality of the image that the newer keyframe was made from, bounds it: where
// vision is weak from the start, C_ref knows nothing better than the few landmarks that there are
// (docs/adr/0010-dr-edges-of-local-ba.md).
//
// Close: with depth in one of the two at least. Far landmarks do not tell how far the robot went,
// however many they are (docs/adr/0007-what-counts-as-tracked.md).
//
// Smoothing. The lack of quality 1 - Q of an edge reaches its neighbours along the temporal chain,
// halved with every hop: lack~(e) = max over edges f, |e - f| <= kSmoothingHops, of
// lack(f) / 2^|e - f|. A maximum, not an average: a poorly connected keyframe strengthens its
// neighbours and never loses its own support to them (paper, fig. dr_ba; the kernel: ADR 10).
#pragma once

#include "backend/core/map/map.h"
#include "backend/core/mapping/mapping_context.h"
#include "common/config/frontend_config.h"

namespace gw::backend {

inline constexpr int kSmoothingHops = 3;
inline constexpr int kInitialConnectionReference = 20;  // C_ref before there is a median (paper)
// Smoothed 1 - Q from which an edge counts as weak: vision does not carry it.
inline constexpr double kWeakLack = 0.5;

// C_ij. Precondition: both are in the map.
int SharedCloseLandmarks(const Map& map, KeyframeId a, KeyframeId b);

// Q of the edge that ends at `to` (from its `previous`). Precondition: `to` is in the map.
double EdgeQuality(const Map& map, KeyframeId to, double connection_reference);

// 1 - (smoothed Q) of the edge that ends at `to`.
double SmoothedLack(const Map& map, KeyframeId to, double connection_reference);

// C_ref: median of C_ij over the newest kReferenceKeyframes temporal edges whose two ends are well
// tracked (num_tracked >= n_trk_ref, where the front-end's quality saturates); not below the
// initial value, which also stands while there are fewer than 3 such edges. Weakly tracked
// keyframes do not count however many they are: in a long bare corridor C_ref stays what good
// tracking gave before it.
inline constexpr size_t kReferenceKeyframes = 20;
double ConnectionReference(const Map& map, const DrWeightConfig& config);

// alpha for the variant: 0 means that the edge is not used. kFixed: the constant; kSwitch:
// alpha_max below switch_q, nothing above; variants without DR in local BA: 0.
double DrScale(double lack, Variant variant, const DrWeightConfig& config);

// alpha of the edge that ends at `to`, for whoever works on the whole map: what local BA left on
// it, or the law above where local BA has not been yet. 0: the edge does not exist or is not used.
double DrEdgeScale(const Map& map, const MappingContext& context, KeyframeId to,
                   double connection_reference);

}  // namespace gw::backend

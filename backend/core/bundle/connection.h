// How well vision ties keyframes that follow each other: reads from the map what the law of
// common/good_weights asks for (docs/method.md, section 3.4).
//
// Close landmarks are those with depth in one of the two keyframes at least. Far landmarks do not
// tell how far the robot went, however many they are (docs/adr/0007-what-counts-as-tracked.md).
#pragma once

#include <map>

#include "backend/core/map/map.h"
#include "backend/core/map/mapping_context.h"
#include "common/config/dr_weight_config.h"

namespace gw::backend {

// C_ij. Precondition: both are in the map.
int SharedCloseLandmarks(const Map& map, KeyframeId a, KeyframeId b);
// The same by the law in force: the paper counts all landmarks that both observe.
int Connection(const Map& map, KeyframeId a, KeyframeId b, const DrWeightConfig& config);

// C_ref before there is a median (Du, Peng, Vela, "Good Weights", arXiv 2509.22910, section III-C),
// and the least that it can be.
inline constexpr int kInitialConnectionReference = 20;

// C_ref: median of C_ij over the newest kReferenceKeyframes temporal edges whose two ends are well
// tracked (num_tracked >= n_trk_ref, where the front-end's quality saturates); not below the
// initial value, which also stands while there are fewer than 3 such edges. Weakly tracked
// keyframes do not count however many they are: in a long bare corridor C_ref stays what good
// tracking gave before it. By the paper's law: PaperConnectionReference.
inline constexpr size_t kReferenceKeyframes = 20;
double ConnectionReference(const Map& map, const DrWeightConfig& config);

// Q_ij of the edge that ends at `to` (from its `previous`). Precondition: `to` is in the map.
double QualityOfEdge(const Map& map, KeyframeId to, double connection_reference,
                     const DrWeightConfig& config);

// 1 - Q_ij of the edge that ends at `to`, or what reaches it of the lack of its neighbours if that
// is more (LackReaching); by the paper's law their mean (PaperSmoothedLack). An edge that does not
// exist lacks nothing.
double SmoothedLack(const Map& map, KeyframeId to, double connection_reference,
                    const DrWeightConfig& config);

// The same for one who asks for many edges of a map that does not change meanwhile: what edges lack
// themselves is counted once.
class EdgeLacks {
 public:
  EdgeLacks(const Map& map, double connection_reference, const DrWeightConfig& config)
      : map_(map), reference_(connection_reference), config_(config) {}
  double Smoothed(KeyframeId to);

 private:
  double Own(const MapKeyframe& to);

  const Map& map_;
  double reference_;
  const DrWeightConfig& config_;
  std::map<KeyframeId, double> own_;
};

// alpha of the edge that ends at `to`, for whoever works on the whole map: what local bundle
// adjustment left on it, or that of its smoothed quality where it has not been yet. 0: the edge
// does not exist or is not used.
double DrEdgeScale(const Map& map, const MappingContext& context, KeyframeId to,
                   double connection_reference);

}  // namespace gw::backend

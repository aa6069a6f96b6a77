#include "backend/core/bundle/connection.h"

#include <algorithm>

#include "backend/core/bundle/paper_connection.h"
#include "common/core/median.h"
#include "common/good_weights/alpha.h"
#include "common/good_weights/quality.h"

namespace gw::backend {
namespace {

bool HasDepth(const MapKeyframe& keyframe, int32_t feature_index) {
  const auto index = static_cast<size_t>(feature_index);
  return index < keyframe.frame.features.size() && keyframe.frame.features[index].has_depth();
}

// Lack of quality of the edge that ends at `to`; a keyframe without an edge lacks nothing.
double Lack(const Map& map, const MapKeyframe& to, double reference, const DrWeightConfig& config) {
  return to.frame.previous.valid() ? 1.0 - QualityOfEdge(map, to.frame.id, reference, config) : 0.0;
}

}  // namespace

int SharedCloseLandmarks(const Map& map, KeyframeId a, KeyframeId b) {
  const MapKeyframe& of_a = *map.FindKeyframe(a);
  const MapKeyframe& of_b = *map.FindKeyframe(b);
  int shared = 0;
  auto in_b = of_b.seen.begin();
  for (const auto& [id, feature] : of_a.seen) {
    while (in_b != of_b.seen.end() && in_b->first < id) ++in_b;
    if (in_b == of_b.seen.end()) break;
    if (in_b->first != id) continue;
    shared += HasDepth(of_a, feature) || HasDepth(of_b, in_b->second);
  }
  return shared;
}

int Connection(const Map& map, KeyframeId a, KeyframeId b, const DrWeightConfig& config) {
  return config.Departs(Departure::kCloseLinks) ? SharedCloseLandmarks(map, a, b)
                                                : map.SharedLandmarks(a, b);
}

double QualityOfEdge(const Map& map, KeyframeId to, double connection_reference,
                     const DrWeightConfig& config) {
  const MapKeyframe& keyframe = map.keyframes().at(to);
  const double shared = map.FindKeyframe(keyframe.frame.previous) == nullptr
                            ? 0
                            : Connection(map, to, keyframe.frame.previous, config);
  const double bound = config.Departs(Departure::kImageQuality) ? keyframe.frame.q : 1.0;
  return EdgeQuality(shared, connection_reference, bound);
}

double EdgeLacks::Own(const MapKeyframe& to) {
  const auto [known, inserted] = own_.try_emplace(to.frame.id, 0.0);
  if (inserted) known->second = Lack(map_, to, reference_, config_);
  return known->second;
}

double EdgeLacks::Smoothed(KeyframeId to) {
  const auto lack = [this](const MapKeyframe& k) { return Own(k); };
  const MapKeyframe* const centre = map_.FindKeyframe(to);
  if (!config_.Departs(Departure::kFading)) return PaperSmoothedLack(map_, *centre, config_, lack);
  double largest = lack(*centre);
  for (const bool forward : {false, true}) {
    const MapKeyframe* at = centre;
    for (int hops = 1; hops <= kSmoothingHops; ++hops) {
      at = map_.FindKeyframe(forward ? at->next : at->frame.previous);
      if (at == nullptr) break;
      largest = std::max(largest, LackReaching(lack(*at), hops));
    }
  }
  return largest;
}

double SmoothedLack(const Map& map, KeyframeId to, double connection_reference,
                    const DrWeightConfig& config) {
  return EdgeLacks(map, connection_reference, config).Smoothed(to);
}

double ConnectionReference(const Map& map, const DrWeightConfig& config) {
  if (!config.Departs(Departure::kReference)) {
    return PaperConnectionReference(map, config, [&](const MapKeyframe& k) {
      return Connection(map, k.frame.id, k.frame.previous, config);
    });
  }
  std::vector<int> counts;
  for (auto it = map.keyframes().rbegin(); it != map.keyframes().rend(); ++it) {
    const MapKeyframe& keyframe = it->second;
    const MapKeyframe* previous = map.FindKeyframe(keyframe.frame.previous);
    if (previous == nullptr || keyframe.frame.num_tracked < config.n_trk_ref ||
        previous->frame.num_tracked < config.n_trk_ref) {
      continue;
    }
    counts.push_back(Connection(map, it->first, keyframe.frame.previous, config));
    if (counts.size() == kReferenceKeyframes) break;
  }
  if (counts.size() < 3) return kInitialConnectionReference;
  return std::max(kInitialConnectionReference, MedianOf(&counts));
}

double DrEdgeScale(const Map& map, const MappingContext& context, KeyframeId to,
                   double connection_reference) {
  const MapKeyframe& keyframe = *map.FindKeyframe(to);
  if (!DrInLocalBa(context.variant)) return 0;
  if (!keyframe.frame.dr || map.FindKeyframe(keyframe.frame.previous) == nullptr) return 0;
  if (keyframe.dr_alpha > 0) return keyframe.dr_alpha;
  const double q = 1.0 - SmoothedLack(map, to, connection_reference, context.dr_weight);
  return EdgeScale(context.variant, q, context.dr_weight);
}

}  // namespace gw::backend

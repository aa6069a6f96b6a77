#include "backend/core/loop/locate.h"

#include <Eigen/LU>
#include <algorithm>
#include <optional>
#include <vector>

#include "backend/core/loop/place_fit.h"
#include "backend/core/map/keyframe_check.h"

namespace gw::backend {
namespace {

constexpr size_t kMaxPlaces = 4;
constexpr double kSamePoseDistance = 0.5;  // m
constexpr double kSamePoseAngle = 0.2;     // rad

std::vector<KeyframeId> Candidates(const Map& map, const PlaceIndex& places,
                                   const PlaceQuery& query) {
  std::vector<KeyframeId> out;
  for (const PlaceScore& place : places.Query(query.descriptors)) {
    if (out.size() == kMaxPlaces || place.num_matches < kFewestMatches / 2) break;
    if (!IsOneOf(map, out, place.keyframe)) out.push_back(place.keyframe);
  }
  return out;
}

}  // namespace

PlaceMatch Locate(const Map& map, const MappingContext& context, const PlaceIndex& places,
                  const PlaceQuery& query) {
  PlaceMatch out;
  out.utime = query.utime;
  out.query_seq = query.seq;
  out.map_revision = map.revision();

  Keyframe frame;  // what CheckKeyframe asks of the rest is not asked of a query
  frame.id = {1};
  frame.features = query.features;
  frame.descriptors = query.descriptors;
  frame.landmarks.assign(query.features.size(), {});
  if (CheckKeyframe(frame) != KeyframeFault::kNone) return out;
  MapKeyframe image;
  image.grid = FeatureGrid(frame.features);
  image.frame = std::move(frame);

  std::optional<PlaceFit> best;
  size_t rival = 0;  // matches of the best fit elsewhere
  for (const KeyframeId candidate : Candidates(map, places, query)) {
    const auto fit = FitPlace(map, context, image, PlaceGroup(map, candidate),
                              static_cast<uint64_t>(query.utime.us));
    if (!fit || !SeesAllAround(*fit)) continue;
    if (best) {
      const SE3 apart = best->T_WC.inverse() * fit->T_WC;
      const bool elsewhere = apart.translation().norm() > kSamePoseDistance ||
                             LogSO3(apart.rotation()).norm() > kSamePoseAngle;
      if (elsewhere) rival = std::max(rival, std::min(best->matches.size(), fit->matches.size()));
      if (fit->matches.size() <= best->matches.size()) continue;
    }
    best = fit;
    out.keyframe = candidate;
  }
  if (!best ||
      static_cast<double>(rival) > kRivalShare * static_cast<double>(best->matches.size())) {
    out.keyframe = {};
    return out;
  }
  out.found = true;
  out.T_WC = best->T_WC;
  out.cov_T_WC = FitCovariance(*best);
  out.num_sights = static_cast<int32_t>(best->matches.size());
  return out;
}

}  // namespace gw::backend

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
                                   const std::vector<Descriptor>& descriptors,
                                   const std::function<bool(KeyframeId)>& asked) {
  std::vector<KeyframeId> out;
  for (const PlaceScore& place : places.Query(descriptors)) {
    if (out.size() == kMaxPlaces || place.num_matches < kFewestMatches / 2) break;
    if (asked(place.keyframe) && !IsOneOf(map, out, place.keyframe)) out.push_back(place.keyframe);
  }
  return out;
}

bool AreElsewhere(const Map& map, const LocatedImage& a, const LocatedImage& b) {
  if (map.PieceOf(a.place) != map.PieceOf(b.place)) return true;
  const SE3 apart = a.fit.T_WC.inverse() * b.fit.T_WC;
  return apart.translation().norm() > kSamePoseDistance ||
         LogSO3(apart.rotation()).norm() > kSamePoseAngle;
}

}  // namespace

std::optional<LocatedImage> LocateImage(const Map& map, const MappingContext& context,
                                        const PlaceIndex& places, const MapKeyframe& image,
                                        uint64_t seed,
                                        const std::function<bool(KeyframeId)>& asked) {
  std::optional<LocatedImage> best;
  size_t rival = 0;  // matches of the best fit elsewhere
  for (const KeyframeId candidate : Candidates(map, places, image.frame.descriptors, asked)) {
    const auto fit = FitPlace(map, context, image, PlaceGroup(map, candidate), seed);
    if (!fit || !SeesAllAround(*fit)) continue;
    const LocatedImage found{*fit, candidate};
    if (best) {
      const size_t fewer = std::min(best->fit.matches.size(), fit->matches.size());
      if (AreElsewhere(map, *best, found)) rival = std::max(rival, fewer);
      if (fit->matches.size() <= best->fit.matches.size()) continue;
    }
    best = found;
  }
  if (!best) return std::nullopt;
  const auto most = static_cast<double>(best->fit.matches.size());
  if (static_cast<double>(rival) > kRivalShare * most) return std::nullopt;
  return best;
}

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
  const auto located =
      LocateImage(map, context, places, image, static_cast<uint64_t>(query.utime.us),
                  [](KeyframeId) { return true; });
  if (!located) return out;
  out.found = true;
  out.keyframe = located->place;
  out.T_WC = located->fit.T_WC;
  out.cov_T_WC = FitCovariance(located->fit);
  out.num_sights = static_cast<int32_t>(located->fit.matches.size());
  return out;
}

}  // namespace gw::backend

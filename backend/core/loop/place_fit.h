// Was this image taken here? Geometric verification of an image against a part of the map.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "backend/core/map/map.h"
#include "backend/core/map/mapping_context.h"

namespace gw::backend {

struct PlaceFit {
  SE3 T_WC;  // of the image, in the map as it stands
  Matrix6d information =
      Matrix6d::Zero();  // of the right perturbation; the landmarks taken as exact
  struct Match {
    int32_t feature = 0;
    LandmarkId landmark;
  };
  std::vector<Match> matches;  // that agree with the pose; sorted by feature
  int num_expected = 0;        // landmarks of the group that should be in sight
  // Share of the parts of the image that should show landmarks and do, [0, 1]. A floor or a poster
  // that is in two places gives many matches, but not of what surrounds it.
  double coverage = 0;
};

// A fit counts from this many matches on. Enough for a loop when it sees this share of what it
// should; for an answer that dead reckoning will be asked to confirm, when it sees this share of
// the image's parts (docs/adr/0009-loops-and-relocalisation.md has the numbers).
inline constexpr int kFewestMatches = 30;
inline constexpr double kFewestShare = 0.25;
inline constexpr double kFewestCoverage = 0.6;
bool SeesItsShare(const PlaceFit& fit);
bool SeesAllAround(const PlaceFit& fit);

// image: features, descriptors and grid are used. group: keyframes of the map whose landmarks are
// tried.
// Descriptors are paired all against all, RANSAC finds the pose that explains most pairs (draws
// depend only on `seed`), then the pose guides a search for the other landmarks, and is optimised.
std::optional<PlaceFit> FitPlace(const Map& map, const MappingContext& context,
                                 const MapKeyframe& image, const std::vector<KeyframeId>& group,
                                 uint64_t seed);

// Covariance of the pose (right perturbation): that of the fit, and a floor for what it leaves out,
// the errors that its landmarks have in common.
Matrix6d FitCovariance(const PlaceFit& fit);

// True when the keyframe shows a place that one of `places` shows: one of each is enough to try.
inline constexpr int kSamePlaceShared = 15;  // landmarks that two views of one place share
bool IsOneOf(const Map& map, const std::vector<KeyframeId>& places, KeyframeId keyframe);

// `centre` and the keyframes that share most landmarks with it, at most kGroupSize.
inline constexpr size_t kGroupSize = 12;
std::vector<KeyframeId> PlaceGroup(const Map& map, KeyframeId centre);

}  // namespace gw::backend

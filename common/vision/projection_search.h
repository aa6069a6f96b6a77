// Where a landmark should appear in an image, and which feature there looks like it. Used by
// tracking, fusion, culling and the guided search of places.
#pragma once

#include <Eigen/Core>
#include <cstdlib>
#include <optional>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/contract/map.h"
#include "common/core/se3.h"
#include "common/vision/feature_grid.h"
#include "common/vision/pyramid.h"
#include "common/vision/reprojection.h"

namespace gw {

// Where a landmark should appear.
struct Projection {
  Eigen::Vector3d p_C;
  Eigen::Vector2d uv;  // px, in the image
  int level = 0;       // of the pyramid, at which it should show
};

// A landmark is searched for up to a fifth outside the range of distances in which its scale lies
// inside the pyramid (the scale of a corner is known to about one level, a factor of 1.2), and up
// to 60 degrees off the direction from which it was seen.
inline constexpr double kDistanceSlack = 1.2;
inline constexpr double kMinCosToNormal = 0.5;

// Landmark: anything with p_W, normal_W, min_distance and max_distance as in LandmarkUpdate. Empty
// when the camera at T_WC should not see it. T_CW = inv(T_WC), both passed because callers ask for
// many landmarks.
template <typename Landmark>
std::optional<Projection> ProjectLandmark(const RectifiedCamera& camera, const Pyramid& pyramid,
                                          const Landmark& landmark, const SE3& T_WC,
                                          const SE3& T_CW) {
  Projection out;
  out.p_C = T_CW * landmark.p_W;
  if (!(out.p_C.z() > kMinProjectionDepth)) return std::nullopt;
  out.uv = camera.Project(out.p_C);
  if (!camera.InImage(out.uv)) return std::nullopt;
  const Eigen::Vector3d ray = landmark.p_W - T_WC.translation();
  const double distance = ray.norm();
  if (distance * kDistanceSlack < landmark.min_distance ||
      distance > landmark.max_distance * kDistanceSlack) {
    return std::nullopt;
  }
  if (ray.dot(landmark.normal_W) < kMinCosToNormal * distance) return std::nullopt;
  out.level = pyramid.PredictLevel(landmark.max_distance, distance);
  return out;
}

// The features of an image, to be searched. Refers to what it was made of.
struct SearchableImage {
  const std::vector<Feature>& features;
  const std::vector<Descriptor>& descriptors;  // one per feature
  const FeatureGrid& grid;                     // of the features
};

// The most similar feature of a search, and the second.
struct BestFeature {
  int index = -1;    // -1: none
  int distance = 0;  // Hamming
  int level = -1;
  int second_distance = 257;  // more than there can be: there is no second
  int second_level = -1;
};

// Among the features within radius_px (square) of the expected pixel, at most one level beside the
// expected one, that accept(index) lets through: the one nearest to `wanted`, of two that are
// equally near the one with the lower index. Only distances up to max_distance count.
template <typename Accept>
BestFeature FindMostSimilar(const SearchableImage& image, const Projection& expected,
                            float radius_px, const Descriptor& wanted, int max_distance,
                            Accept&& accept) {
  BestFeature out;
  out.distance = max_distance + 1;
  image.grid.ForEachNear(static_cast<float>(expected.uv.x()), static_cast<float>(expected.uv.y()),
                         radius_px, [&](int i) {
                           const Feature& f = image.features[static_cast<size_t>(i)];
                           if (std::abs(f.level - expected.level) > 1 || !accept(i)) return;
                           const int d =
                               HammingDistance(wanted, image.descriptors[static_cast<size_t>(i)]);
                           if (d < out.distance || (d == out.distance && out.index > i)) {
                             out.second_distance = out.index < 0 ? 257 : out.distance;
                             out.second_level = out.level;
                             out.distance = d;
                             out.level = f.level;
                             out.index = i;
                           } else if (d < out.second_distance) {
                             out.second_distance = d;
                             out.second_level = f.level;
                           }
                         });
  return out;
}

}  // namespace gw

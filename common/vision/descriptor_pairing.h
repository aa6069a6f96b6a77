// Which features of an image show which of many landmarks, without a prediction: descriptors are
// compared all against all, and the distance to the second nearest tells whether the nearest is
// unmistakable. For places whose pose nobody knows.
#pragma once

#include <cstddef>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/contract/map.h"
#include "common/vision/pose_ransac.h"
#include "common/vision/pyramid.h"

namespace gw {

struct NearestTwo {
  size_t index = 0;  // of the nearest point; of two that are equally near, the first
  int best = 257;    // Hamming distances; 257, more than there can be, where there is no such point
  int second = 257;
};

// Point: anything with a `descriptor`.
template <typename Point>
NearestTwo FindNearestTwo(const Descriptor& descriptor, const std::vector<const Point*>& points) {
  NearestTwo out;
  for (size_t i = 0; i < points.size(); ++i) {
    const int d = HammingDistance(descriptor, points[i]->descriptor);
    if (d < out.best) {
      out.second = out.best;
      out.best = d;
      out.index = i;
    } else if (d < out.second) {
      out.second = d;
    }
  }
  return out;
}

// Stricter than a search around a prediction, as nothing but geometry guards a pair: distance of at
// most 60 of 256 bits, and of at most 0.85 of the second nearest landmark's.
inline constexpr int kPairDistance = 60;
inline constexpr double kPairRatio = 0.85;
inline constexpr double kPairTolerancePx = 4;  // at level 0: noise of the feature and its landmark

// Features with depth and the landmarks they look like; each feature and each landmark at most
// once. Landmark: anything with a `descriptor` and `p_W`.
template <typename Landmark>
std::vector<PointPair> PairDescriptors(const RectifiedCamera& camera, const Pyramid& pyramid,
                                       const std::vector<Feature>& features,
                                       const std::vector<Descriptor>& descriptors,
                                       const std::vector<const Landmark*>& landmarks) {
  struct Best {
    int distance = kPairDistance + 1;
    size_t feature = 0;
  };
  std::vector<Best> best_of(landmarks.size());
  for (size_t i = 0; i < features.size(); ++i) {
    if (!features[i].has_depth()) continue;
    const NearestTwo near = FindNearestTwo(descriptors[i], landmarks);
    if (near.best > kPairDistance || near.best > kPairRatio * near.second) continue;
    if (near.best < best_of[near.index].distance) best_of[near.index] = {near.best, i};
  }
  std::vector<PointPair> pairs;
  for (size_t k = 0; k < landmarks.size(); ++k) {
    if (best_of[k].distance > kPairDistance) continue;
    const Feature& f = features[best_of[k].feature];
    pairs.push_back({camera.Unproject(f.u, f.v, f.depth),
                     landmarks[k]->p_W,
                     {f.u, f.v},
                     kPairTolerancePx * pyramid.Scale(f.level)});
  }
  return pairs;
}

}  // namespace gw

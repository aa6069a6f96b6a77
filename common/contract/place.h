// Where was this image taken? The front-end asks when it does not know where it is in the map, or
// doubts it; the back-end, which has the whole map, answers.
#pragma once

#include <cstdint>
#include <vector>

#include "common/contract/map.h"

namespace gw {

struct PlaceQuery {
  Utime utime;  // of the image
  int64_t seq = 0;
  std::vector<Feature> features;
  std::vector<Descriptor> descriptors;  // one per feature
};

struct PlaceMatch {
  Utime utime;  // of the image asked about
  int64_t seq = 0;
  int64_t query_seq = 0;
  // False: the map holds no such place, or more than one that looks like it. The rest is then
  // empty.
  bool found = false;
  SE3 T_WC;                              // in the map of map_revision
  Matrix6d cov_T_WC = Matrix6d::Zero();  // right perturbation
  int32_t num_sights = 0;                // landmarks that support it
  int64_t map_revision = 0;
  KeyframeId keyframe;  // the one that looks most like the image
};

}  // namespace gw

// Finds the features of an image that show given landmarks, by projecting the landmarks with a
// predicted pose and comparing descriptors inside a window.
#pragma once

#include <vector>

#include "common/camera/camera_model.h"
#include "common/vision/projection_search.h"
#include "frontend/core/map/local_map.h"

namespace gw::frontend {

// A landmark to look for.
struct Candidate {
  const MapPoint* point = nullptr;
  const Descriptor* descriptor = nullptr;  // what it should look like
  int level = -1;                          // expected pyramid level; -1: from its distance
  float radius_px = 0;                     // window at level 0; grows with the level
};

struct MatcherLimits {
  int max_distance = 100;  // Hamming, of 256
  double max_ratio = 0.9;  // best to second best of the same level; 1 switches the test off
};

class ProjectionMatcher {
 public:
  ProjectionMatcher(const RectifiedCamera& camera, const Pyramid& pyramid)
      : camera_(camera), pyramid_(pyramid) {}

  // match[i] becomes the index into `candidates` of the landmark that feature i shows, plus
  // `first_index`. Features with match[i] >= 0 on entry are taken and stay as they are; the others
  // that show none keep -1. A feature wanted by several landmarks goes to the most similar one.
  // Returns how many features were matched in this call.
  int Match(const SE3& T_WC, const std::vector<Candidate>& candidates, int first_index,
            const SearchableImage& image, const MatcherLimits& limits,
            std::vector<int>* match) const;

  // Where the image should show the candidate; empty when it should not. T_CW = inv(T_WC).
  std::optional<Projection> Expect(const Candidate& candidate, const SE3& T_WC,
                                   const SE3& T_CW) const;

 private:
  RectifiedCamera camera_;
  Pyramid pyramid_;
};

}  // namespace gw::frontend

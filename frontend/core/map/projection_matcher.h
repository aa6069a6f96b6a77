// Finds the features of an image that show given landmarks, by projecting the landmarks with a
// predicted pose and comparing descriptors inside a window.
#pragma once

#include <vector>

#include "common/camera/camera_model.h"
#include "frontend/core/features/feature_frame.h"
#include "frontend/core/map/feature_grid.h"
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
  int max_distance = 100;     // Hamming, of 256
  double max_ratio = 0.9;     // best to second best of the same level; 1 switches the test off
  double min_view_cos = 0.5;  // between the viewing ray and the landmark's mean one
};

struct MatchStatistics {
  int num_visible = 0;  // candidates inside the image, at a fitting distance and angle
  int num_matched = 0;
};

class ProjectionMatcher {
 public:
  ProjectionMatcher(const RectifiedCamera& camera, const PyramidScale& scale);

  // match[i] is the index into `candidates` of the landmark that feature i shows, or -1. Features
  // with match[i] >= 0 on entry are taken and stay as they are; indices are offset by
  // `first_index`. A feature wanted by several landmarks goes to the most similar one.
  MatchStatistics Match(const SE3& T_WC, const std::vector<Candidate>& candidates, int first_index,
                        const FeatureFrame& frame, const FeatureGrid& grid,
                        const MatcherLimits& limits, std::vector<int>* match) const;

  int PredictLevel(const MapPoint& point, double distance) const;
  double LevelScale(int level) const { return level_scale_[level]; }

 private:
  RectifiedCamera camera_;
  std::vector<double> level_scale_;
  double log_factor_;
};

}  // namespace gw::frontend

// Tuning of the tracking front-end (section `frontend`). Defaults are those of Du, Peng, Vela,
// "Good Weights", arXiv 2509.22910, where they give a number, otherwise measured on the recordings
// named in docs/results.md.
#pragma once

#include "common/config/dr_weight_config.h"
#include "common/core/fields.h"

namespace gw {

struct OrbConfig {
  int num_features = 800;
  int num_levels = 8;
  double scale_factor = 1.2;
  int fast_threshold = 20;
  int fast_threshold_low = 7;
  // Corners that are edges are dropped (docs/method.md, section 3.2). No robot's configuration can
  // change it: it follows from the method.
  bool corners_only = true;

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Field("num_features", num_features,
            {.min = 50,
             .max = 5000,
             .unit = "count",
             .text = "features kept per image, spread over the image"});
    v.Field("num_levels", num_levels,
            {.min = 1, .max = 12, .unit = "count", .text = "pyramid levels"});
    v.Field("scale_factor", scale_factor,
            {.min = 1.05,
             .max = 2,
             .text = "size ratio of neighbouring levels; also the pixel sigma's base"});
    v.Field(
        "fast_threshold", fast_threshold,
        {.min = 2, .max = 100, .unit = "grey levels", .text = "corner contrast first asked for"});
    v.Field("fast_threshold_low", fast_threshold_low,
            {.min = 2,
             .max = 100,
             .unit = "grey levels",
             .text = "corner contrast where a region has too few corners"});
  }
};

// Which of the landmarks that should be in sight are looked for in an image.
enum class Matching {
  kAll,
  kGood,    // those that tell most of the pose, up to a budget (docs/method.md, section 5.12)
  kRandom,  // as many, drawn at random: what kGood is measured against
};

struct FrontendConfig {
  Variant variant = Variant::kFull;
  Matching matching = Matching::kAll;
  int matching_budget = 400;
  OrbConfig orb;
  DrWeightConfig dr_weight;
  bool calibrate_dr = true;
  int min_inliers = 12;
  int keyframe_max_interval_ms = 1000;
  double keyframe_overlap = 0.75;
  int keyframe_min_close = 100;

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Enum("variant", variant,
           {{"none", Variant::kNone},
            {"da", Variant::kDa},
            {"pe", Variant::kPe},
            {"lba", Variant::kLba},
            {"full", Variant::kFull},
            {"fixed", Variant::kFixed},
            {"switch", Variant::kSwitch}},
           {.text = "where dead reckoning enters: nowhere, matching, + pose estimation, + local "
                    "BA, everywhere; or a baseline"});
    v.Enum(
        "matching", matching,
        {{"all", Matching::kAll}, {"good", Matching::kGood}, {"random", Matching::kRandom}},
        {.text = "which landmarks are looked for in an image: all that should be in sight, or "
                 "within a budget those that tell most of the pose, or random ones (a baseline)"});
    v.Field("matching_budget", matching_budget,
            {.min = 50,
             .max = 5000,
             .unit = "count",
             .text = "matching `good` and `random`: most matches per image"});
    v.Section("orb", orb, {.text = "feature extraction"});
    v.Section("dr_weight", dr_weight,
              {.text = "Good Weights: tracking quality and the scale of the DR prior"});
    v.Field("calibrate_dr", calibrate_dr,
            {.text = "while vision is healthy, learn the scale errors of heading and way, and the "
                     "direction of driving"});
    v.Field("min_inliers", min_inliers,
            {.min = 6,
             .max = 500,
             .unit = "count",
             .text = "fewest inliers that make a pose from vision"});
    v.Field("keyframe_max_interval_ms", keyframe_max_interval_ms,
            {.min = 100,
             .max = 60000,
             .unit = "ms",
             .text = "longest time without a keyframe while the view changes"});
    v.Field("keyframe_overlap", keyframe_overlap,
            {.min = 0.1,
             .max = 1,
             .text = "share of the reference keyframe's landmarks still tracked, below which a "
                     "keyframe is made"});
    v.Field("keyframe_min_close", keyframe_min_close,
            {.min = 0,
             .max = 5000,
             .unit = "count",
             .text = "tracked landmarks with depth, below which a keyframe is made when others "
                     "wait untracked"});
  }
};

}  // namespace gw

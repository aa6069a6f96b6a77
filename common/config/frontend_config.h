// Tuning of the tracking front-end (section `frontend`). Defaults are the paper's where it gives a
// number, otherwise measured on the recordings named in docs/results.md.
#pragma once

#include "common/core/fields.h"

namespace gw {

// Which modules use dead reckoning (method.md section 3; `kFixed` and `kSwitch` are baselines).
enum class Variant { kNone, kDa, kPe, kLba, kFull, kFixed, kSwitch };

inline bool DrPredicts(Variant v) {
  return v != Variant::kNone;
}
inline bool DrInPoseEstimation(Variant v) {
  return v != Variant::kNone && v != Variant::kDa;
}
inline bool DrInLocalBa(Variant v) {
  return DrInPoseEstimation(v) && v != Variant::kPe;
}
inline bool DrInGlobalBa(Variant v) {
  return DrInLocalBa(v) && v != Variant::kLba;
}
// The scale of the DR information follows the quality of tracking (the others: none, or a
// baseline).
inline bool AdaptsAlpha(Variant v) {
  return v == Variant::kPe || v == Variant::kLba || v == Variant::kFull;
}

struct OrbConfig {
  int num_features = 800;
  int num_levels = 8;
  double scale_factor = 1.2;
  int fast_threshold = 20;
  int fast_threshold_low = 7;

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

struct DrWeightConfig {
  double alpha_min = 1e-1;
  double alpha_max = 1e3;
  double n_det_ref = 600;
  double n_trk_ref = 120;
  double omega_det = 0.5;
  double sigma_trans_m_per_frame = 0.004;
  double sigma_rot_deg_per_frame = 0.1;
  double fixed_alpha = 1.0;
  double switch_q = 0.3;

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Field("alpha_min", alpha_min,
            {.min = 1e-9,
             .max = 1e9,
             .text = "scale of the DR information at quality 1 (paper III-B)"});
    v.Field("alpha_max", alpha_max,
            {.min = 1e-9,
             .max = 1e9,
             .text = "scale of the DR information at quality 0 (paper III-B)"});
    v.Field("n_det_ref", n_det_ref,
            {.min = 1,
             .max = 5000,
             .unit = "count",
             .text = "detected features that mean full quality"});
    v.Field("n_trk_ref", n_trk_ref,
            {.min = 1,
             .max = 5000,
             .unit = "count",
             .text = "tracked features that mean full quality"});
    v.Field(
        "omega_det", omega_det,
        {.min = 0, .max = 1, .text = "weight of detection in the quality; tracking has the rest"});
    v.Field("sigma_trans_m_per_frame", sigma_trans_m_per_frame,
            {.min = 1e-6, .max = 1, .unit = "m", .text = "nominal DR noise per 1/30 s, each axis"});
    v.Field(
        "sigma_rot_deg_per_frame", sigma_rot_deg_per_frame,
        {.min = 1e-6, .max = 45, .unit = "deg", .text = "nominal DR noise per 1/30 s, each axis"});
    v.Field("fixed_alpha", fixed_alpha,
            {.min = 0, .max = 1e12, .text = "variant `fixed`: the constant scale"});
    v.Field("switch_q", switch_q,
            {.min = 0, .max = 1, .text = "variant `switch`: quality below which DR alone is used"});
  }
};

struct FrontendConfig {
  Variant variant = Variant::kFull;
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

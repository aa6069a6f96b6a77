// Where dead reckoning (DR) enters, and how strongly: the section `frontend.dr_weight`, which the
// back-end uses as well. Defaults are those of Du, Peng, Vela, "Good Weights", arXiv 2509.22910,
// where it gives a number (section III-B).
#pragma once

#include "common/config/departure.h"
#include "common/core/fields.h"

namespace gw {

// Which modules use dead reckoning (docs/method.md, section 3). kFixed and kSwitch are the
// baselines that Du, Peng, Vela, "Good Weights", arXiv 2509.22910, argue against.
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

struct DrWeightConfig {
  Method method = Method::kOurs;
  double alpha_min = 1e-1;
  double alpha_max = 1e3;
  double n_det_ref = 600;
  double n_trk_ref = 120;
  double omega_det = 0.5;
  double sigma_trans_m_per_frame = 0.004;
  double sigma_rot_deg_per_frame = 0.1;
  double fixed_alpha = 1.0;
  double switch_q = 0.3;
  // Departures that are the other way than `method` has them. For experiments only: no robot's
  // configuration can set it.
  DepartureSet changed = {};

  bool Departs(Departure d) const { return (method == Method::kOurs) != changed.Contains(d); }

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Enum("method", method, {{"ours", Method::kOurs}, {"paper", Method::kPaper}},
           {.text = "the law in force: this project's, or section III of the paper as printed"});
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

}  // namespace gw

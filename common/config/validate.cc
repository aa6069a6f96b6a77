#include "common/config/validate.h"

#include "common/camera/camera_model.h"
#include "common/core/format.h"

namespace gw {
namespace {

// MakeCameraGeometry names the field first: "calibration.camera.left: principal point ...".
RuleViolation FromGeometryError(const std::string& message) {
  const size_t end = message.find_first_of(": ");
  if (end == std::string::npos) return {"calibration.camera", message};
  const size_t rule = message.find_first_not_of(": ", end);
  return {message.substr(0, end), rule == std::string::npos ? message : message.substr(rule)};
}

}  // namespace

std::vector<RuleViolation> CheckRules(const RobotConfig& config) {
  std::vector<RuleViolation> out;
  const CameraCalibration& camera = config.calibration.camera;
  if (camera.kind == CameraKind::kStereo) {
    if (camera.right.fx <= 0) {
      out.push_back({"calibration.camera.right", "missing, kind: stereo needs both eyes"});
    }
    if (camera.T_C0C1.translation().norm() == 0) {
      out.push_back({"calibration.camera.T_C0C1",
                     "missing, kind: stereo needs the right camera's pose in the left's frame"});
    }
  }
  const auto geometry = MakeCameraGeometry(config.calibration);
  if (!geometry && out.empty()) out.push_back(FromGeometryError(geometry.error().message));

  const DrWeightConfig& weight = config.frontend.dr_weight;
  if (weight.alpha_max < weight.alpha_min) {
    out.push_back({"frontend.dr_weight.alpha_max",
                   "must not be smaller than alpha_min (" + FormatDouble(weight.alpha_min) +
                       "); dead reckoning counts more when tracking is worse"});
  }
  const OrbConfig& orb = config.frontend.orb;
  if (orb.fast_threshold_low > orb.fast_threshold) {
    out.push_back({"frontend.orb.fast_threshold_low", "must not be larger than fast_threshold (" +
                                                          std::to_string(orb.fast_threshold) +
                                                          "); lower it or raise fast_threshold"});
  }
  const NavigateConfig& navigate = config.navigate;
  if (navigate.slow_sigma_m >= navigate.stop_sigma_m) {
    out.push_back({"navigate.slow_sigma_m", "must be smaller than stop_sigma_m (" +
                                                FormatDouble(navigate.stop_sigma_m) + ")"});
  }
  if (navigate.slow_sigma_deg >= navigate.stop_sigma_deg) {
    out.push_back({"navigate.slow_sigma_deg", "must be smaller than stop_sigma_deg (" +
                                                  FormatDouble(navigate.stop_sigma_deg) + ")"});
  }
  return out;
}

}  // namespace gw

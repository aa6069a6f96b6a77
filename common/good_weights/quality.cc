#include "common/good_weights/quality.h"

#include <algorithm>
#include <cmath>

namespace gw {

double ImageQuality(const TrackingHealth& health, const DrWeightConfig& config) {
  const double detected = std::clamp(health.num_detected / config.n_det_ref, 0.0, 1.0);
  const double tracked = std::clamp(health.num_tracked / config.n_trk_ref, 0.0, 1.0);
  return config.omega_det * detected + (1.0 - config.omega_det) * tracked;
}

double EdgeQuality(double shared_close, double connection_reference, double quality_of_newer) {
  return std::clamp(std::min(shared_close / connection_reference, quality_of_newer), 0.0, 1.0);
}

double LackReaching(double lack, int hops) {
  return std::ldexp(lack, -hops);
}

bool VisionMayJudgeDr(const FramePose& frame) {
  return frame.status == TrackingStatus::kTracking && frame.q >= 0.9 && frame.dr_share <= 0.01;
}

}  // namespace gw

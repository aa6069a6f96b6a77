// Dead reckoning made from ground truth, for recordings without odometry: the true motion of the
// body with a stated error. Every state is marked synthetic.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/contract/dead_reckoning.h"
#include "common/contract/samples.h"
#include "common/core/result.h"

namespace gw::importer {

// The error of the increment over dt is Exp(n + b dt) on its right:
//   n ~ N(0, sigma^2 * 30 dt) per axis: sigma is "per frame" of 30 Hz (docs/method.md, section 1.3)
//   b ~ N(0, bias^2) per axis at the begin, then a random walk of walk per sqrt(s).
// cov_twist_white and cov_twist_coherent state exactly this, so that DrHistory::Increment is
// honest.
struct SyntheticDrOptions {
  double sigma_t_m = 0.004;
  double sigma_r_rad = 0.1 * 0.017453292519943295;
  double bias_t_m_s = 0;
  double bias_r_rad_s = 0;
  double walk_t_m_s_sqrt_s = 0;
  double walk_r_rad_s_sqrt_s = 0;
  double rate_hz = 100;
  uint64_t seed = 1;
};

// "sigma_t=0.004,sigma_r=0.1deg,bias_t=0.01,bias_r=0.05deg,walk_t=0,walk_r=0rad,rate=100,seed=1",
// each at most once, missing ones keep their default. Rotations (sigma_r, bias_r, walk_r) need the
// unit deg or rad. Error: kInvalidArgument.
Result<SyntheticDrOptions> ParseSyntheticDr(const std::string& text);

// All values, in the notation of ParseSyntheticDr.
std::string Describe(const SyntheticDrOptions& options);

// States at rate_hz from the first to the last ground truth; O is the first body pose. Velocities
// are those of the true motion plus the bias (what a filter would report; the white part averages
// out). Both sensors are reported alive, since the stream stands in for them. A gap of more than
// 0.2 s in the ground truth is bridged on the geodesic, with a warning. Error: kBadData with fewer
// than two ground-truth samples.
Result<std::vector<DrState>> MakeSyntheticDr(const std::vector<GroundTruth>& ground_truth,
                                             const SyntheticDrOptions& options,
                                             std::vector<std::string>& warnings);

}  // namespace gw::importer

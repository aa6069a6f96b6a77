#include "tools/lab/bench_suite/lidar_truth.h"

#include <numbers>

#include "common/core/random.h"
#include "tools/lab/eval/smooth.h"

namespace gw::bench {

Result<eval::Trajectory> AsOfLidar(const eval::Trajectory& truth, const LidarTruth& lidar,
                                   uint64_t seed) {
  constexpr uint64_t kStream = 0x11DA;
  const double radians = lidar.degrees * std::numbers::pi / 180;
  const DurationUs period = DurationFromSeconds(1 / lidar.rate_hz);
  eval::Trajectory samples;
  for (const eval::TimedPose& pose : truth) {
    if (!samples.empty() && pose.utime < samples.back().utime + period) continue;
    CounterRng rng(seed, kStream, samples.size());
    const Eigen::Vector3d dp(rng.Normal(), rng.Normal(), rng.Normal());
    const Eigen::Vector3d dr(rng.Normal(), rng.Normal(), rng.Normal());
    samples.push_back({pose.utime, SE3(pose.T.rotation() * ExpSO3(radians * dr),
                                       pose.T.translation() + lidar.metres * dp)});
  }
  const auto smoothed = eval::Smooth(samples, {});
  if (!smoothed) return Error{smoothed.error().code, "ground truth " + smoothed.error().message};
  return eval::Sample(*smoothed, samples, 100);
}

}  // namespace gw::bench

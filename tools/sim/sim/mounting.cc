#include "tools/sim/sim/mounting.h"

#include <cmath>
#include <numbers>

#include "tools/sim/sim/part_tolerance.h"

namespace gw::sim {
namespace {

Eigen::Vector3d AnyDirection(CounterRng* rng) {
  const double x = rng->Normal(), y = rng->Normal(), z = rng->Normal();
  return Eigen::Vector3d(x, y, z).normalized();
}

}  // namespace

SE3 MountedAt(const SE3& nominal_T_BC, const MountingConfig& config, uint64_t seed) {
  CounterRng rng(seed, 0x30047, 0);
  const Eigen::Vector3d axis = AnyDirection(&rng);
  const double angle = DrawError(&rng, config.camera_deg) * std::numbers::pi / 180;
  const Eigen::Vector3d direction = AnyDirection(&rng);
  const double shift = DrawError(&rng, config.camera_m);
  return SE3((ExpSO3(angle * axis) * nominal_T_BC.rotation()).normalized(),
             nominal_T_BC.translation() + shift * direction);
}

}  // namespace gw::sim

// Trajectories for the tests of this folder.
#pragma once

#include <cmath>

#include "common/core/random.h"
#include "tools/lab/eval/trajectory.h"

namespace gw::eval {

// A pose that only shifts.
inline TimedPose At(double seconds, double x, double y, double z = 0) {
  return {UtimeFromSeconds(seconds), SE3(Eigen::Quaterniond::Identity(), {x, y, z})};
}

// A robot that drives an eight on slightly uneven ground.
inline Trajectory Eight(int poses, double period_s) {
  Trajectory out;
  for (int i = 0; i < poses; ++i) {
    const double t = i * period_s;
    const SE3 T(ExpSO3({0.02 * std::sin(t), 0.01 * std::cos(3 * t), 0.4 * t}),
                {3 * std::sin(0.4 * t), 2 * std::sin(0.8 * t), 0.1 * std::sin(0.7 * t)});
    out.push_back({UtimeFromSeconds(t), T});
  }
  return out;
}

inline Trajectory Moved(const SE3& T, Trajectory trajectory) {
  for (TimedPose& pose : trajectory) pose.T = T * pose.T;
  return trajectory;
}

inline SE3 RandomPose(CounterRng& rng) {
  const Eigen::Quaterniond q(rng.Normal(), rng.Normal(), rng.Normal(), rng.Normal());
  return SE3(q, {rng.Uniform(-9, 9), rng.Uniform(-9, 9), rng.Uniform(-9, 9)});
}

}  // namespace gw::eval

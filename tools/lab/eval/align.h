// Which pose of the reference belongs to which pose of the estimate, and the rigid motion that
// brings the two trajectories together.
#pragma once

#include <vector>

#include "tools/lab/eval/trajectory.h"

namespace gw::eval {

struct PosePair {
  Utime utime;  // of the estimate
  SE3 T_ref;
  SE3 T_est;
};

// The reference is evaluated at the estimate's time: interpolated on the SE(3) geodesic between its
// neighbouring samples when these are at most max_gap apart, else its nearest sample when that is
// at most max_diff away, else the estimate's pose has no partner.
// Why not nearest samples throughout: a body at 1 m/s moves 5 mm in half the period of a 100 Hz
// reference, which would be counted as error of the estimate. Why the reference and not the
// estimate: interpolating the estimate would smooth its noise away.
std::vector<PosePair> Associate(const Trajectory& ref, const Trajectory& est, DurationUs max_gap,
                                DurationUs max_diff);

enum class Alignment {
  kSe3,   // 6 degrees of freedom (Umeyama 1991, without scale)
  kYaw,   // 4: turn about z and shift, for estimates that know gravity
  kNone,  // the trajectories share a frame
};

// T_RefEst that minimises the sum of squared distances between T_ref.p and T_RefEst * T_est.p.
// Error: kBadData when the positions do not determine it (no pair, all in one place; for kSe3: all
// on a line). Scale is never estimated: stereo, RGB-D and wheels know it.
Result<SE3> Align(const std::vector<PosePair>& pairs, Alignment alignment);

}  // namespace gw::eval

// The loops of a drive: where the robot came back to by its true poses, and what the map made of
// it.
//
// The robot revisits a place while it stands within kRevisitDistance and kRevisitAngle of where it
// was at least kRevisitAfter before: it then sees what it saw. The map has closed that loop when a
// keyframe of the revisit shares enough landmarks with one from before. Keyframes that share as
// many although they were kFalseDistance apart are joined falsely.
#pragma once

#include <optional>
#include <vector>

#include "tools/lab/eval/trajectory.h"

namespace gw::study {

inline constexpr double kRevisitDistance = 0.5;  // m
inline constexpr double kRevisitAngle = 20.0;    // deg
inline constexpr DurationUs kRevisitAfter = Milliseconds(30000);
inline constexpr double kFalseDistance = 8.0;  // m; farther than stereo and depth see
// A revisit may be noticed a little before and after it counts as one.
inline constexpr DurationUs kRevisitMargin = Milliseconds(3000);

struct Revisit {
  Utime begin, end;
};

// In order of time; the truth is looked at every 0.2 s. Pauses of up to 1 s do not part a revisit.
std::vector<Revisit> FindRevisits(const eval::Trajectory& truth);

// Two keyframes that share landmarks: when their images were taken, and how far apart (m).
struct CovisiblePair {
  Utime older, newer;
  double distance_m = 0;  // by their true poses
};

struct RevisitOutcome {
  Revisit revisit;
  int64_t pairs = 0;                // that join it to before; 0: the loop is still open
  std::optional<DurationUs> delay;  // from its begin to the first keyframe that does
};
std::vector<RevisitOutcome> JudgeRevisits(const std::vector<Revisit>& revisits,
                                          const std::vector<CovisiblePair>& pairs);

int64_t CountFalsePairs(const std::vector<CovisiblePair>& pairs);

}  // namespace gw::study

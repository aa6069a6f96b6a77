#include "tools/lab/study/revisits.h"

#include <algorithm>

#include "tools/lab/study/same_view.h"

namespace gw::study {
namespace {

constexpr DurationUs kStep = Milliseconds(200);
constexpr DurationUs kLongestPause = Milliseconds(1000);  // within a revisit

eval::Trajectory Thinned(const eval::Trajectory& truth) {
  eval::Trajectory out;
  for (const eval::TimedPose& pose : truth) {
    if (out.empty() || pose.utime - out.back().utime >= kStep) out.push_back(pose);
  }
  return out;
}

}  // namespace

std::vector<Revisit> FindRevisits(const eval::Trajectory& truth) {
  const eval::Trajectory poses = Thinned(truth);
  std::vector<Revisit> out;
  for (const eval::TimedPose& now : poses) {
    const bool again = std::any_of(poses.begin(), poses.end(), [&](const eval::TimedPose& before) {
      return now.utime - before.utime >= kRevisitAfter &&
             SameView(before.T, now.T, kRevisitDistance, kRevisitAngle);
    });
    if (!again) continue;
    if (out.empty() || now.utime - out.back().end > kLongestPause) {
      out.push_back({now.utime, now.utime});
    }
    out.back().end = now.utime;
  }
  return out;
}

std::vector<RevisitOutcome> JudgeRevisits(const std::vector<Revisit>& revisits,
                                          const std::vector<CovisiblePair>& pairs) {
  std::vector<RevisitOutcome> out;
  for (const Revisit& revisit : revisits) {
    RevisitOutcome outcome{revisit, 0, {}};
    for (const CovisiblePair& pair : pairs) {
      if (pair.newer - pair.older < kRevisitAfter - kRevisitMargin ||
          pair.newer < revisit.begin - kRevisitMargin ||
          pair.newer > revisit.end + kRevisitMargin) {
        continue;
      }
      ++outcome.pairs;
      const DurationUs delay = std::max(DurationUs{}, pair.newer - revisit.begin);
      if (!outcome.delay || delay < *outcome.delay) outcome.delay = delay;
    }
    out.push_back(outcome);
  }
  return out;
}

int64_t CountFalsePairs(const std::vector<CovisiblePair>& pairs) {
  return std::count_if(pairs.begin(), pairs.end(),
                       [](const CovisiblePair& p) { return p.distance_m >= kFalseDistance; });
}

}  // namespace gw::study

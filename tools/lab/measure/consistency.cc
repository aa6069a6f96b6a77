#include "tools/lab/measure/consistency.h"

#include <Eigen/Cholesky>
#include <map>

#include "tools/lab/eval/evaluate.h"

namespace gw::measure {
namespace {

enum class Sight { kNone, kBlind, kSeeing };

Sight SightOf(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::kTracking:
    case TrackingStatus::kDegraded:
    case TrackingStatus::kRecovering:
      return Sight::kSeeing;
    case TrackingStatus::kDrOnly:
      return Sight::kBlind;
    default:
      return Sight::kNone;
  }
}

void Count(const Vector6d& error, const Matrix6d& cov, NeesCount* count) {
  ++count->windows;
  const Eigen::LLT<Matrix6d> factor(cov);
  if (factor.info() != Eigen::Success) {
    ++count->undefined;
    return;
  }
  const double nees = error.dot(factor.solve(error));
  count->inside += nees >= kNeesLow && nees <= kNeesHigh;
  count->above += nees > kNeesHigh;
}

// Per image, how many of the images up to it are of a kind.
std::vector<int> Cumulative(const std::vector<FramePose>& frames, Sight sight) {
  std::vector<int> out;
  int sum = 0;
  for (const FramePose& f : frames) out.push_back(sum += SightOf(f.status) == sight);
  return out;
}

}  // namespace

Consistency MeasureConsistency(const SlamRun& run, const eval::Trajectory& truth) {
  Consistency out;
  const std::vector<FramePose>& frames = run.frames;
  const eval::EvalOptions options;
  std::map<Utime, SE3> truth_at;
  for (const eval::PosePair& pair :
       eval::Associate(truth, run.Live(), options.max_gap, options.max_diff)) {
    truth_at[pair.utime] = pair.T_ref;
  }
  const std::vector<int> blind = Cumulative(frames, Sight::kBlind);
  const std::vector<int> without = Cumulative(frames, Sight::kNone);
  size_t a = 0;
  for (size_t b = 0; b < frames.size(); ++b) {
    if (frames[b].motion_us == 0) continue;
    const Utime begin = frames[b].utime - DurationUs{frames[b].motion_us};
    while (frames[a].utime < begin) ++a;
    if (frames[a].utime != begin) continue;
    const auto truth_a = truth_at.find(frames[a].utime);
    const auto truth_b = truth_at.find(frames[b].utime);
    if (truth_a == truth_at.end() || truth_b == truth_at.end()) continue;
    if (SightOf(frames[a].status) == Sight::kNone || without[b] > without[a]) continue;

    const SE3 motion = frames[a].T_WB.inverse() * frames[b].T_WB;
    const SE3 true_motion = truth_a->second.inverse() * truth_b->second;
    const Vector6d error = (true_motion.inverse() * motion).Log();
    const bool any_blind = blind[b] > blind[a] || SightOf(frames[a].status) == Sight::kBlind;
    Count(error, frames[b].cov_motion, any_blind ? &out.blind : &out.healthy);
  }
  return out;
}

}  // namespace gw::measure

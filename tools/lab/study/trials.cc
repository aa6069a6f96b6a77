#include "tools/lab/study/trials.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "common/core/random.h"
#include "tools/lab/study/same_view.h"

namespace gw::study {
namespace {

constexpr uint64_t kStartStream = 0x57A7;
constexpr uint64_t kCarryStream = 0xCA44;

bool Claims(const FramePose& frame) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(frame.cov_T_WB.topLeftCorner<3, 3>());
  return axes.eigenvalues().maxCoeff() < kClaimSigma * kClaimSigma;
}

struct View {
  Utime utime;
  SE3 T_GB;
};

const View& Draw(const std::vector<View>& views, CounterRng* rng) {
  return views[rng->Below(static_cast<uint32_t>(views.size()))];
}

}  // namespace

bool MappedViews::InSight(const SE3& T_GB) const {
  return std::any_of(T_GB_.begin(), T_GB_.end(), [&](const SE3& keyframe) {
    return SameView(keyframe, T_GB, kViewDistance, kViewAngle);
  });
}

std::vector<Trial> DrawTrials(const eval::Trajectory& truth, const MappedViews& views,
                              const TrialPlan& plan) {
  std::vector<Trial> out;
  if (truth.empty()) return out;
  const Utime log_end = truth.back().utime;
  std::vector<View> mapped, foreign;  // where a trial may begin
  for (const eval::TimedPose& pose : truth) {
    if (pose.utime + kShortestTrial > log_end) break;
    (views.InSight(pose.T) ? mapped : foreign).push_back({pose.utime, pose.T});
  }
  const auto end_of = [&](Utime since) { return std::min(since + plan.length, log_end); };
  for (const std::vector<View>* kind : {&mapped, &foreign}) {
    if (kind->empty()) continue;
    const bool in_sight = kind == &mapped;
    CounterRng starts(plan.seed, kStartStream, in_sight ? 1 : 0);
    for (int i = 0; i < plan.starts; ++i) {
      const View& view = Draw(*kind, &starts);
      out.push_back({in_sight, view.utime, end_of(view.utime), std::nullopt});
    }
    // A carry that leads back in the log, or to the same view, is drawn anew.
    constexpr int kMaxDraws = 1000;
    CounterRng carries(plan.seed, kCarryStream, in_sight ? 1 : 0);
    int made = 0;
    for (int draw = 0; draw < kMaxDraws && made < plan.carries && !mapped.empty(); ++draw) {
      const View& begin = Draw(mapped, &carries);
      const View& to = Draw(*kind, &carries);
      const Utime from = begin.utime + kBeforeCarry;
      const auto left = std::lower_bound(
          truth.begin(), truth.end(), from,
          [](const eval::TimedPose& pose, Utime utime) { return pose.utime < utime; });
      if (from >= to.utime || SameView(left->T, to.T_GB, kViewDistance, kViewAngle)) continue;
      out.push_back({in_sight, begin.utime, end_of(to.utime), Trial::Carry{from, to.utime}});
      ++made;
    }
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Trial& a, const Trial& b) { return a.begin < b.begin; });
  return out;
}

std::optional<DurationUs> TrialOutcome::Delay() const {
  if (!localised) return std::nullopt;
  return view && *view < *localised ? *localised - *view : DurationUs{};
}

void TrialJudge::See(Utime at, const FramePose& frame, const SE3& T_GB, const SE3& T_GB_true,
                     bool in_sight) {
  const SE3 error = T_GB_true.inverse() * T_GB;
  const double error_m = error.translation().norm();
  const bool claims = Claims(frame);
  const bool right = claims && error_m < kRightDistance && AngleDeg(error) < kRightAngle;
  ++outcome_.images;
  if (claims) outcome_.worst_claim_m = std::max(outcome_.worst_claim_m, error_m);
  if (claims && error_m > kWrongDistance) ++outcome_.wrong;
  if (at < trial_.since()) {
    outcome_.knew = right;
    return;
  }
  if (in_sight && !outcome_.view) outcome_.view = at - trial_.since();
  if (right && frame.num_inliers > 0 && !outcome_.localised) {
    outcome_.localised = at - trial_.since();
    outcome_.error_m = error_m;
    outcome_.error_deg = AngleDeg(error);
  }
}

bool TrialJudge::Over(Utime at) const {
  return outcome_.localised && at - trial_.since() > *outcome_.localised + kAfterwards;
}

}  // namespace gw::study

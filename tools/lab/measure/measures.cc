#include "tools/lab/measure/measures.h"

#include <algorithm>

namespace gw::measure {
namespace {

bool VisionCarries(TrackingStatus status) {
  return status == TrackingStatus::kTracking || status == TrackingStatus::kDegraded;
}

bool IsLost(TrackingStatus status) {
  return status == TrackingStatus::kLost || status == TrackingStatus::kInitializing ||
         status == TrackingStatus::kInvalid;
}

std::optional<double> ApeRmse(const Result<eval::Evaluation>& evaluation) {
  if (!evaluation) return std::nullopt;
  return evaluation->ape_translation_m.rmse;
}

}  // namespace

Jumps MeasureJumps(const SlamRun& run) {
  Jumps jumps;
  for (size_t i = 1; i < run.frames.size(); ++i) {
    if (!run.T_OB[i - 1] || !run.T_OB[i]) continue;
    const FramePose& before = run.frames[i - 1];
    const FramePose& now = run.frames[i];
    const SE3 dr_motion = run.T_OB[i - 1]->inverse() * *run.T_OB[i];
    const SE3 motion = before.T_WB.inverse() * now.T_WB;
    const double jump = (dr_motion.inverse() * motion).translation().norm();
    const bool recovery = now.status == TrackingStatus::kRecovering ||
                          (VisionCarries(now.status) && !VisionCarries(before.status));
    double& worst = recovery ? jumps.worst_recovery_m : jumps.worst_m;
    worst = std::max(worst, jump);
  }
  return jumps;
}

double Median(std::vector<double> values) {
  return eval::Summarise(std::move(values)).median;
}

double Quantile(std::vector<double> values, double q) {
  const auto at =
      values.begin() + static_cast<ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Measures Measure(const SlamRun& run, const eval::Trajectory& truth, eval::Alignment alignment) {
  Measures out;
  out.images = static_cast<int64_t>(run.frames.size());
  std::vector<double> ms;
  for (size_t i = 0; i < run.frames.size(); ++i) {
    out.lost += IsLost(run.frames[i].status);
    out.blind += run.frames[i].status == TrackingStatus::kDrOnly;
    if (run.ms[i]) ms.push_back(*run.ms[i]);
  }
  eval::EvalOptions options;
  options.alignment = alignment;
  const auto live = eval::Evaluate(truth, run.Live(), options);
  out.ape_live_m = ApeRmse(live);
  if (live && live->rpe_translation_m.count > 0) {
    out.rpe_m = live->rpe_translation_m.rmse;
    out.rpe_deg = live->rpe_rotation_deg.rmse;
  }
  out.ape_final_m = ApeRmse(eval::Evaluate(truth, run.Final(), options));
  out.ape_dr_m = ApeRmse(eval::Evaluate(truth, run.DeadReckoning(), options));
  out.jumps = MeasureJumps(run);
  out.consistency = MeasureConsistency(run, truth);
  if (!ms.empty()) {
    out.ms_p99 = Quantile(ms, 0.99);
    out.ms_median = Median(std::move(ms));
  }
  return out;
}

}  // namespace gw::measure

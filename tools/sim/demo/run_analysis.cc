#include "tools/sim/demo/run_analysis.h"

#include <algorithm>
#include <cmath>

namespace gw::demo {
namespace {

constexpr DurationUs kSameInstant{1000};
constexpr double kWayStep = 0.01;  // m; less is jitter

// The truth of an image's instant; gw-sim publishes it with every image.
const GroundTruth* TruthAt(const std::vector<GroundTruth>& truth, Utime utime) {
  const auto next = std::lower_bound(truth.begin(), truth.end(), utime - kSameInstant,
                                     [](const GroundTruth& g, Utime t) { return g.utime < t; });
  if (next == truth.end() || next->utime > utime + kSameInstant) return nullptr;
  // The nearer one of two that are within reach counts.
  const auto after = next + 1;
  if (after == truth.end()) return &*next;
  const auto off = [utime](const GroundTruth& g) { return std::abs((g.utime - utime).us); };
  return off(*after) < off(*next) ? &*after : &*next;
}

void FindBlindSpans(RunAnalysis* run) {
  for (size_t i = 0; i < run->frames.size(); ++i) {
    const FramePoint& frame = run->frames[i];
    if (!IsBlind(frame.status)) continue;
    // A pose holds until the next image.
    const double end = i + 1 < run->frames.size() ? run->frames[i + 1].t : frame.t;
    if (!run->blind.empty() && frame.t <= run->blind.back().second) {
      run->blind.back().second = end;
    } else {
      run->blind.emplace_back(frame.t, end);
    }
  }
  for (const auto& [begin, end] : run->blind) run->blind_s += end - begin;
}

void Summarise(RunAnalysis* run) {
  double sum2 = 0;
  int count = 0;
  std::optional<Eigen::Vector2d> last;
  for (const FramePoint& frame : run->frames) {
    if (frame.error_m) {
      sum2 += *frame.error_m * *frame.error_m;
      ++count;
      run->error_max_m = std::max(run->error_max_m, *frame.error_m);
      run->error_end_m = *frame.error_m;
    }
    const Eigen::Vector2d p = frame.truth.value_or(frame.position);
    const double step = last ? (p - *last).norm() : 0;
    if (last && step < kWayStep) continue;
    run->way_m += step;
    last = p;
  }
  run->has_truth = count > 0;
  if (count > 0) run->error_rmse_m = std::sqrt(sum2 / count);
}

}  // namespace

bool IsBlind(TrackingStatus status) {
  return status == TrackingStatus::kDrOnly || status == TrackingStatus::kRecovering ||
         status == TrackingStatus::kLost;
}

RunAnalysis Analyse(const tools::Monitor& monitor) {
  RunAnalysis run;
  std::optional<SE3> T_GW;
  for (const tools::Monitor::Frame& frame : monitor.frames()) {
    if (frame.pose.status == TrackingStatus::kInitializing) continue;
    if (run.frames.empty()) run.begin = frame.pose.utime;
    const GroundTruth* truth = TruthAt(monitor.truth(), frame.pose.utime);
    if (truth != nullptr && !T_GW) T_GW = truth->T_GB * frame.pose.T_WB.inverse();
    const SE3 T_GB = T_GW ? *T_GW * frame.pose.T_WB : frame.pose.T_WB;
    FramePoint point;
    point.t = (frame.pose.utime - run.begin).seconds();
    point.status = frame.pose.status;
    point.q = frame.pose.q;
    point.alpha = frame.pose.alpha;
    point.position = T_GB.translation().head<2>();
    point.latency_ms = static_cast<double>(frame.latency_us) * 1e-3;
    if (truth != nullptr) {
      point.truth = truth->T_GB.translation().head<2>();
      point.error_m = (T_GB.translation() - truth->T_GB.translation()).norm();
    }
    run.frames.push_back(point);
  }
  FindBlindSpans(&run);
  Summarise(&run);
  return run;
}

std::optional<double> ErrorNow::Of(const tools::Monitor& monitor) {
  if (monitor.frames().empty()) return std::nullopt;
  const FramePose& pose = monitor.frames().back().pose;
  const GroundTruth* truth = TruthAt(monitor.truth(), pose.utime);
  if (truth == nullptr || pose.status == TrackingStatus::kInitializing) return std::nullopt;
  if (!T_GW_) T_GW_ = truth->T_GB * pose.T_WB.inverse();
  return ((*T_GW_ * pose.T_WB).translation() - truth->T_GB.translation()).norm();
}

}  // namespace gw::demo

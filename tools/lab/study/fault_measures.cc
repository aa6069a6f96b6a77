#include "tools/lab/study/fault_measures.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace gw::study {
namespace {

constexpr double kMovedDistance = 0.05;         // m
constexpr double kMovedAngle = 3 * M_PI / 180;  // rad

constexpr DurationUs kBegin = Milliseconds(1000);

// The covariance tells how sure a pose is of where the map begins: there, in the mean of the first
// second, estimate and truth are laid over each other. T_RefEst. Precondition: some pair.
SE3 AlignBegin(const std::vector<eval::PosePair>& pairs) {
  const SE3 first = pairs.front().T_ref * pairs.front().T_est.inverse();
  Vector6d sum = Vector6d::Zero();
  int count = 0;
  for (const eval::PosePair& pair : pairs) {
    if (pair.utime - pairs.front().utime > kBegin) break;
    sum += (first.inverse() * pair.T_ref * pair.T_est.inverse()).Log();
    ++count;
  }
  return first * SE3::Exp(sum / count);
}

// Distance of the pose from the truth in sigmas of its position. The covariance is that of a
// perturbation on the right: in the axes of the body.
double Sigmas(const SE3& T_ref, const SE3& T_est, const Matrix6d& cov) {
  const Eigen::Vector3d error_B =
      T_est.rotation().conjugate() * (T_ref.translation() - T_est.translation());
  const Eigen::LLT<Eigen::Matrix3d> factor(cov.topLeftCorner<3, 3>());
  if (factor.info() != Eigen::Success) return 0;
  return std::sqrt(error_B.dot(factor.solve(error_B)));
}

bool HasPose(const FramePose& frame) {
  return frame.status != TrackingStatus::kLost && frame.status != TrackingStatus::kInitializing &&
         frame.status != TrackingStatus::kInvalid;
}

// Fills in how long and how often the published poses were too sure.
void JudgeCovariance(const std::vector<FramePose>& frames, const std::vector<eval::PosePair>& pairs,
                     FaultNumbers* out) {
  if (pairs.empty()) return;
  const SE3 T_RefEst = AlignBegin(pairs);
  std::map<Utime, const eval::PosePair*> pair_at;
  for (const eval::PosePair& pair : pairs) pair_at[pair.utime] = &pair;
  Utime begin;
  bool inside = false;
  double tracking = 0, too_sure = 0;
  for (const FramePose& frame : frames) {
    const auto pair = pair_at.find(frame.utime);
    if (pair == pair_at.end()) continue;  // no truth: says nothing
    const bool tracks = frame.status == TrackingStatus::kTracking;
    const SE3 T_est = T_RefEst * pair->second->T_est;
    tracking += tracks;
    if (!tracks || !(Sigmas(pair->second->T_ref, T_est, frame.cov_T_WB) > kTooSureSigmas)) {
      inside = false;
      continue;
    }
    ++too_sure;
    if (!inside) begin = frame.utime;
    inside = true;
    out->too_sure_s = std::max(out->too_sure_s, (frame.utime - begin).seconds());
  }
  if (tracking > 0) out->too_sure_share = too_sure / tracking;
}

}  // namespace

FaultNumbers MeasureFault(const measure::SlamRun& run, const SE3& T_BB,
                          const eval::Trajectory& truth, eval::Alignment alignment) {
  FaultNumbers out;
  out.images = static_cast<int64_t>(run.frames.size());
  bool any_pose = false;
  eval::Trajectory live;
  for (const FramePose& frame : run.frames) {
    any_pose |= HasPose(frame);
    out.without_pose += any_pose && !HasPose(frame);
    out.blind += frame.status == TrackingStatus::kDrOnly;
    live.push_back({frame.utime, frame.T_WB * T_BB});
  }
  if (!any_pose) out.without_pose = out.images;
  eval::EvalOptions options;
  options.alignment = alignment;
  const auto evaluation = eval::Evaluate(truth, live, options);
  if (!evaluation) return out;
  out.ape_m = evaluation->ape_translation_m.rmse;
  JudgeCovariance(run.frames, evaluation->pairs, &out);
  return out;
}

std::optional<double> Ape(const eval::Trajectory& truth, const eval::Trajectory& estimate,
                          eval::Alignment alignment) {
  eval::EvalOptions options;
  options.alignment = alignment;
  const auto evaluation = eval::Evaluate(truth, estimate, options);
  if (!evaluation || !std::isfinite(evaluation->ape_translation_m.rmse)) return std::nullopt;
  return evaluation->ape_translation_m.rmse;
}

Utime FirstMotion(const eval::Trajectory& truth) {
  for (const eval::TimedPose& pose : truth) {
    const SE3 T = truth.front().T.inverse() * pose.T;
    if (T.translation().norm() > kMovedDistance || LogSO3(T.rotation()).norm() > kMovedAngle) {
      return pose.utime;
    }
  }
  return truth.empty() ? Utime{} : truth.back().utime;
}

}  // namespace gw::study

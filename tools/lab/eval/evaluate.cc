#include "tools/lab/eval/evaluate.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gw::eval {
namespace {

constexpr double kMinStep = 0.01;     // m
constexpr int64_t kPausePeriods = 3;  // of the estimate's median period

double Degrees(const SE3& T) {
  return LogSO3(T.rotation()).norm() * 180.0 / std::numbers::pi;
}

void MeasureRpe(const std::vector<PosePair>& pairs, DurationUs delta, Evaluation* out) {
  std::vector<double> translation_m;
  std::vector<double> rotation_deg;
  const DurationUs tolerance{delta.us / 10};
  size_t j = 0;
  for (const PosePair& begin : pairs) {
    const Utime target = begin.utime + delta;
    const auto distance = [&](size_t k) { return std::abs((pairs[k].utime - target).us); };
    while (j + 1 < pairs.size() && distance(j + 1) < distance(j)) ++j;
    if (distance(j) > tolerance.us) continue;
    const SE3 error = MotionError(begin, pairs[j]);
    translation_m.push_back(error.translation().norm());
    rotation_deg.push_back(Degrees(error));
  }
  out->rpe_translation_m = Summarise(std::move(translation_m));
  out->rpe_rotation_deg = Summarise(std::move(rotation_deg));
}

Drift MeasureDrift(const std::vector<PosePair>& pairs, const std::vector<double>& distance,
                   const std::vector<double>& lengths) {
  Drift drift;
  drift.path_length_m = distance.back() - distance.front();
  const SE3 final_error = MotionError(pairs.front(), pairs.back());
  drift.final_error_m = final_error.translation().norm();
  drift.final_error_deg = Degrees(final_error);
  if (drift.path_length_m > 0) {
    drift.final_percent = 100.0 * drift.final_error_m / drift.path_length_m;
  }
  double percent = 0;
  double deg_per_m = 0;
  for (const double length : lengths) {
    size_t end = 0;
    for (size_t begin = 0; begin < pairs.size(); ++begin) {
      while (end < pairs.size() && distance[end] < distance[begin] + length) ++end;
      if (end == pairs.size()) break;
      const SE3 error = MotionError(pairs[begin], pairs[end]);
      percent += 100.0 * error.translation().norm() / length;
      deg_per_m += Degrees(error) / length;
      ++drift.segments;
    }
  }
  if (drift.segments > 0) {
    drift.segment_percent = percent / static_cast<double>(drift.segments);
    drift.segment_deg_per_m = deg_per_m / static_cast<double>(drift.segments);
  }
  return drift;
}

}  // namespace

SE3 MotionError(const PosePair& a, const PosePair& b) {
  return (a.T_ref.inverse() * b.T_ref).inverse() * (a.T_est.inverse() * b.T_est);
}

Stats Summarise(std::vector<double> errors) {
  Stats stats;
  stats.count = static_cast<int64_t>(errors.size());
  if (errors.empty()) return stats;
  std::sort(errors.begin(), errors.end());
  double sum = 0;
  double sum_of_squares = 0;
  for (const double e : errors) {
    sum += e;
    sum_of_squares += e * e;
  }
  const auto count = static_cast<double>(errors.size());
  const size_t middle = errors.size() / 2;
  stats.rmse = std::sqrt(sum_of_squares / count);
  stats.mean = sum / count;
  stats.median =
      errors.size() % 2 == 1 ? errors[middle] : 0.5 * (errors[middle - 1] + errors[middle]);
  stats.max = errors.back();
  return stats;
}

std::vector<double> DistanceAt(const Trajectory& ref, const std::vector<PosePair>& pairs) {
  std::vector<double> out;
  double way = 0;
  size_t next = 0;
  Eigen::Vector3d counted = ref.empty() ? Eigen::Vector3d::Zero() : ref.front().T.translation();
  for (const PosePair& pair : pairs) {
    for (; next < ref.size() && ref[next].utime <= pair.utime; ++next) {
      const double step = (ref[next].T.translation() - counted).norm();
      if (step < kMinStep) continue;
      way += step;
      counted = ref[next].T.translation();
    }
    out.push_back(way);
  }
  return out;
}

DurationUs MedianPeriod(const Trajectory& poses) {
  std::vector<DurationUs> periods;
  for (size_t i = 1; i < poses.size(); ++i) periods.push_back(poses[i].utime - poses[i - 1].utime);
  std::sort(periods.begin(), periods.end());
  return periods[periods.size() / 2];
}

DurationUs LongestPause(const Trajectory& est) {
  if (est.size() < 2) return {};
  return {kPausePeriods * MedianPeriod(est).us};
}

std::vector<std::pair<double, double>> Gaps(const Trajectory& ref, const Trajectory& est) {
  std::vector<std::pair<double, double>> gaps;
  if (ref.empty()) return gaps;
  const Utime ref_begin = ref.front().utime;
  const Utime ref_end = ref.back().utime;
  const DurationUs pause = LongestPause(est);
  const auto add = [&](Utime begin, Utime end) {
    if (end - begin <= pause) return;
    begin = std::max(begin, ref_begin);
    end = std::min(end, ref_end);
    if (begin < end) gaps.emplace_back((begin - ref_begin).seconds(), (end - ref_begin).seconds());
  };
  if (est.size() < 2) {
    add(ref_begin, ref_end);
    return gaps;
  }
  add(ref_begin, est.front().utime);
  for (size_t i = 1; i < est.size(); ++i) add(est[i - 1].utime, est[i].utime);
  add(est.back().utime, ref_end);
  return gaps;
}

double Completeness(const Trajectory& ref, const Trajectory& est) {
  if (ref.size() < 2) return 0;
  double open_s = 0;
  for (const auto& [begin, end] : Gaps(ref, est)) open_s += end - begin;
  return 1.0 - open_s / (ref.back().utime - ref.front().utime).seconds();
}

double Coverage(const std::vector<Utime>& frames, const Trajectory& est) {
  int64_t covered = 0;
  for (const Utime frame : frames) {
    const auto pose =
        std::lower_bound(est.begin(), est.end(), frame - DurationUs{1},
                         [](const TimedPose& p, Utime utime) { return p.utime < utime; });
    if (pose != est.end() && pose->utime <= frame + DurationUs{1}) ++covered;
  }
  return static_cast<double>(covered) / static_cast<double>(frames.size());
}

Result<Evaluation> Evaluate(const Trajectory& ref, const Trajectory& est,
                            const EvalOptions& options) {
  if (ref.empty()) return Error{ErrorCode::kBadData, "the reference holds no pose"};
  if (est.empty()) return Error{ErrorCode::kBadData, "the estimate holds no pose"};
  Evaluation out;
  out.num_ref = static_cast<int64_t>(ref.size());
  out.num_est = static_cast<int64_t>(est.size());
  out.pairs = Associate(ref, est, options.max_gap, options.max_diff);
  if (out.pairs.empty()) {
    const auto span = [](const Trajectory& t) {
      return std::to_string(t.front().utime.us) + " to " + std::to_string(t.back().utime.us);
    };
    return Error{ErrorCode::kBadData,
                 "no pose of the estimate has a reference pose at its time (us): reference " +
                     span(ref) + ", estimate " + span(est) + "; same recording, same clock?"};
  }
  const Result<SE3> T_RefEst = Align(out.pairs, options.alignment);
  if (!T_RefEst) return T_RefEst.error();
  out.T_RefEst = *T_RefEst;
  for (PosePair& pair : out.pairs) {
    pair.T_est = out.T_RefEst * pair.T_est;
    out.ape_m.push_back((pair.T_ref.translation() - pair.T_est.translation()).norm());
    out.ape_deg.push_back(Degrees(pair.T_ref.inverse() * pair.T_est));
  }
  out.ape_translation_m = Summarise(out.ape_m);
  out.ape_rotation_deg = Summarise(out.ape_deg);
  MeasureRpe(out.pairs, options.rpe_delta, &out);
  out.drift = MeasureDrift(out.pairs, DistanceAt(ref, out.pairs), options.segment_lengths_m);
  out.completeness = Completeness(ref, est);
  return out;
}

}  // namespace gw::eval

// How far an estimated trajectory is from the reference.
//
// Pairs (T_ref, T_est) come from Associate(); E' = T_RefEst * T_est is the aligned estimate.
//   APE   |p_ref - p_E'| (m) and the angle of inv(R_ref) R_E' (deg), for every pair
//   RPE   the motion over rpe_delta: inv(inv(T_ref_i) T_ref_j) (inv(T_est_i) T_est_j), with j the
//         pair nearest to t_i + rpe_delta, used when within a tenth of rpe_delta of it; needs no
//         alignment
//   drift the same motion error from the first pair to the last, per way (final), and the mean over
//         all stretches of the given lengths, per length (KITTI's measure: Geiger et al. 2012)
// The way is that of the reference, counted in steps of at least 1 cm, so that the jitter of a
// reference at rest does not add up.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "tools/lab/eval/align.h"

namespace gw::eval {

struct EvalOptions {
  Alignment alignment = Alignment::kSe3;
  DurationUs max_gap = Milliseconds(100);  // longest hole of the reference to interpolate over
  DurationUs max_diff = Milliseconds(20);  // farthest reference sample to use as it is
  DurationUs rpe_delta = Milliseconds(1000);
  std::vector<double> segment_lengths_m = {1, 2, 5, 10, 20, 50, 100, 200, 400, 800};
};

struct Stats {
  int64_t count = 0;  // 0: nothing to measure, the others mean nothing
  double rmse = 0;
  double mean = 0;
  double median = 0;  // of an even count: between the middle two
  double max = 0;
};
Stats Summarise(std::vector<double> errors);

struct Drift {
  double path_length_m = 0;  // of the reference between the first and the last pair
  double final_error_m = 0;  // at the last pair, when the first ones coincide
  double final_error_deg = 0;
  std::optional<double> final_percent;      // of the path length; empty without motion
  int64_t segments = 0;                     // stretches found; 0: the next two are empty
  std::optional<double> segment_percent;    // mean translation error per length
  std::optional<double> segment_deg_per_m;  // mean rotation error per length
};

struct Evaluation {
  int64_t num_ref = 0;
  int64_t num_est = 0;
  SE3 T_RefEst;                 // the alignment
  std::vector<PosePair> pairs;  // T_est is aligned
  std::vector<double> ape_m;    // one per pair
  std::vector<double> ape_deg;
  Stats ape_translation_m, ape_rotation_deg;
  Stats rpe_translation_m, rpe_rotation_deg;
  Drift drift;
  double completeness = 0;  // see Completeness()
};

// Error: kBadData, when there is nothing to compare or the alignment is not determined.
Result<Evaluation> Evaluate(const Trajectory& ref, const Trajectory& est,
                            const EvalOptions& options);

// What the estimate makes of the motion from a to b, seen from what it really was.
SE3 MotionError(const PosePair& a, const PosePair& b);

// Median time from pose to pose. Precondition: at least two poses.
DurationUs MedianPeriod(const Trajectory& poses);

// How long the estimate may stay silent and still count as coming: three times its median period.
// Zero for less than two poses.
DurationUs LongestPause(const Trajectory& est);

// The stretches of the reference's time span, in seconds since its begin, where the estimate is
// silent for more than LongestPause(): before its first pose, between poses, after its last.
std::vector<std::pair<double, double>> Gaps(const Trajectory& ref, const Trajectory& est);

// Share of the reference's time span outside of all Gaps(), in [0, 1].
double Completeness(const Trajectory& ref, const Trajectory& est);

// Share of the images that have a pose at their very time (+-1 us: files are rounded), in [0, 1].
// Precondition: frames is not empty.
double Coverage(const std::vector<Utime>& frames, const Trajectory& est);

// How far the reference has come, at each of the given increasing times; steps below 1 cm wait
// until they add up.
std::vector<double> DistanceAt(const Trajectory& ref, const std::vector<PosePair>& pairs);

}  // namespace gw::eval

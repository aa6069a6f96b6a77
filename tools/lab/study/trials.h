// Trials of localisation in a saved map: which are made, and how one is judged.
//
// A view is mapped when the robot stood within 1 m and 30 deg of there at a keyframe of the map
// (the measure of tools/lab/slam/place_study.cc). A pose claims a place when its covariance puts
// the position within 0.1 m (1 sigma, along its worst axis); the claim is right within 0.3 m and 5
// deg, and wrong from 0.5 m on. The robot is localised at the first image of which vision carries
// the pose, which claims a place, and is right.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "common/contract/tracking.h"
#include "tools/lab/eval/trajectory.h"

namespace gw::study {

inline constexpr double kViewDistance = 1.0;  // m
inline constexpr double kViewAngle = 30.0;    // deg
inline constexpr double kClaimSigma = 0.1;    // m
inline constexpr double kRightDistance = 0.3;
inline constexpr double kRightAngle = 5.0;  // deg
inline constexpr double kWrongDistance = 0.5;

// True poses of the body at the keyframes of a map, in the frame of the ground truth.
class MappedViews {
 public:
  explicit MappedViews(std::vector<SE3> T_GB) : T_GB_(std::move(T_GB)) {}
  bool InSight(const SE3& T_GB) const;

 private:
  std::vector<SE3> T_GB_;
};

// A run over a part of the log, from nothing but the map: all events from `begin` to `end`. With a
// carry, the robot is set down at once, unnoticed by its sensors, where it is at `carry_to`.
struct Trial {
  bool mapped = false;  // a mapped view is in sight where it begins, or is set down
  Utime begin, end;     // times of the log
  struct Carry {
    Utime from, to;  // begin < from < to < end
  };
  std::optional<Carry> carry;

  // From here on it is to find its place.
  Utime since() const { return carry ? carry->to : begin; }
};

struct TrialPlan {
  int starts = 50;    // with a mapped view in sight, and as many without
  int carries = 20;   // to a mapped view, and as many to where none is
  DurationUs length;  // of a trial, without what comes before a carry
  uint64_t seed = 1;
};

// What the robot does before it is carried: long enough to find its place in the map.
inline constexpr DurationUs kBeforeCarry = Milliseconds(5000);
// A trial may end with the log, but is not shorter than this.
inline constexpr DurationUs kShortestTrial = Milliseconds(10000);

// Seeded draws over the poses of the log's truth, by order of begin. A carry begins with a mapped
// view in sight, leads forward in the log, and to another view: 1 m or 30 deg away. Fewer than
// asked for where the log has no such place (no kind is drawn in place of another).
std::vector<Trial> DrawTrials(const eval::Trajectory& truth, const MappedViews& views,
                              const TrialPlan& plan);

struct TrialOutcome {
  bool knew = false;                    // before a carry: its last pose was right
  std::optional<DurationUs> view;       // since Trial::since(): until a mapped view is in sight
  std::optional<DurationUs> localised;  // since Trial::since()
  double error_m = 0, error_deg = 0;    // when it was localised
  int64_t images = 0;
  int64_t wrong = 0;         // images with a wrong claim, over the whole trial
  double worst_claim_m = 0;  // largest error of a claim

  // How long it took while it could know; >= 0.
  std::optional<DurationUs> Delay() const;
};

// Sees the images of one trial in order.
class TrialJudge {
 public:
  explicit TrialJudge(const Trial& trial) : trial_(trial) {}

  // at: of the image, in times of the log. T_GB: its published pose, brought into the frame of the
  // truth.
  void See(Utime at, const FramePose& frame, const SE3& T_GB, const SE3& T_GB_true, bool in_sight);

  // Nothing more is to be learned: localised, and kAfterwards has passed.
  static constexpr DurationUs kAfterwards = Milliseconds(2000);
  bool Over(Utime at) const;

  const TrialOutcome& outcome() const { return outcome_; }

 private:
  Trial trial_;
  TrialOutcome outcome_;
};

}  // namespace gw::study

// Landmarks that are known to stand still: for a while they were inliers of poses on which vision
// and dead reckoning (DR) agreed. Where the two contradict each other these decide: what came into
// view since then may be on a person who walks by.
//
// A single contradiction proves nothing, vision's covariance is too small for that. Sound witnesses
// agree on an image with a probability of 0.7 (hand-held camera; 0.99 on wheels), and on one whose
// pose moves with a person of 0.1: every image is evidence of log(0.7 / 0.1) for or log(0.3 / 0.9)
// against its inliers, and 1000 to 1 is proof.
#pragma once

#include <vector>

#include "common/contract/map.h"
#include "common/core/id_table.h"
#include "common/core/time.h"

namespace gw::frontend {

class StandingLandmarks {
 public:
  // The time of agreement that is enough, over which vision and DR are compared, too.
  static constexpr DurationUs kProof = Milliseconds(500);
  // What has been out of sight for longer is forgotten: it may have been moved.
  static constexpr DurationUs kMemory = Milliseconds(10000);

  // Inliers of the pose of an image (invalid ids are skipped). agreed: vision and DR agree on it.
  void Observe(Utime utime, bool agreed, const std::vector<LandmarkId>& inliers);

  // A landmark that was merged into another is known by that one.
  void Merge(const std::vector<LandmarkMerge>& merges);

  bool Knows(LandmarkId id) const {
    const Known* known = known_.Find(id.value);
    return known != nullptr && known->proven;
  }
  bool KnowsAny() const { return knows_any_; }
  // How many of these it knows; invalid ids are skipped.
  int Count(const std::vector<LandmarkId>& ids) const;

 private:
  struct Known {
    Utime since;          // first image as an inlier
    Utime seen;           // newest
    double evidence = 0;  // that it stands still, log of the odds
    bool proven = false;
  };
  void Forget(Utime now);

  IdTable<Known> known_;
  Utime cleaned_;
  bool knows_any_ = false;  // since the begin
};

}  // namespace gw::frontend

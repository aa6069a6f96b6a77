// Landmarks that are known to stand still: for a while they were inliers of poses on which vision
// and dead reckoning (DR) agreed, and at no image of it the two contradicted each other. Where they
// do, these decide: what has come into view since then may be on a person who walks by.
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

  // Inliers of the pose of an image (invalid ids are skipped). agreed: vision and DR agree on it.
  void Observe(Utime utime, bool agreed, const std::vector<LandmarkId>& inliers);

  // A landmark that was merged into another is known by that one.
  void Merge(const std::vector<LandmarkMerge>& merges);

  bool Knows(LandmarkId id) const {
    const Known* known = known_.Find(id.value);
    return known != nullptr && known->proven;
  }
  // How many of these it knows; invalid ids are skipped.
  int Count(const std::vector<LandmarkId>& ids) const;

 private:
  // What has been out of sight for longer is forgotten: it may have been moved.
  static constexpr DurationUs kMemory = Milliseconds(10000);

  struct Known {
    Utime since;  // first image of the agreement
    Utime seen;   // newest image as an inlier
    bool proven = false;
  };
  template <typename Wanted>
  void Forget(const Wanted& wanted);

  IdTable<Known> known_;
  Utime cleaned_;
};

}  // namespace gw::frontend

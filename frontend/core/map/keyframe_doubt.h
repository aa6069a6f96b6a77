// How far keyframes may be off from where the map begins: the drift of what was mapped.
//
// A keyframe is off by the error of its pose in the map around it (PoseUncertainty), and by what
// that map is off itself. A pose is found among landmarks, and each of them is off by what the
// keyframe is that first saw it. So errors add up like the steps of a random walk wherever old
// landmarks give way to new ones: slowly where vision is rich, fast where it is weak, with all the
// drift of dead reckoning where it is blind.
//
// A loop ties two ends of the walk together. What lies between is off like a Brownian bridge, what
// comes after it goes on from the older end.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "common/contract/map.h"
#include "common/core/se3.h"
#include "frontend/core/map/local_map.h"

namespace gw::frontend {

class KeyframeDoubt {
 public:
  // Covariance of the right perturbation of T_WC, for a camera that the keyframe sees at T_KC. Zero
  // for a keyframe of which nothing is kept, as one of a map that was loaded.
  Matrix6d At(KeyframeId id, const SE3& T_KC) const;
  // ... for a pose that vision found among these landmarks: the mean over them, as if all steps of
  // the walk were in common. Empty: none of them is in the map.
  std::optional<Matrix6d> Among(const std::vector<LandmarkId>& landmarks, const LocalMap& map,
                                const SE3& T_WC) const;

  // A keyframe, newer than all others, and the covariance of its pose. Right perturbation.
  void Add(KeyframeId id, const Matrix6d& cov_T_WK);
  // The map was closed by a loop, and has its new poses.
  void Close(const LoopEvent& loop, const LocalMap& map);
  void Remove(KeyframeId id) { keyframes_.erase(id); }

 private:
  struct Entry {
    Matrix6d cov;
    double walked;  // variance of all steps up to here, whatever loops took away: m^2 + rad^2
  };

  std::map<KeyframeId, Entry> keyframes_;
};

}  // namespace gw::frontend

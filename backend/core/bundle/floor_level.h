// The floor that dead reckoning (DR) stands on, in the map.
//
// DR holds a robot to its floor: its height in O wanders by a few centimetres and does not drift,
// where vision's does, by the tilt that a stretch of weak vision leaves (docs/method.md, section
// 3.5; docs/adr/0065-what-the-floor-holds.md). A run is a series of keyframes that follow each
// other in time while DR goes on without a reset, all in one piece of the map. Within it the
// heights in W and in O differ by one number, the level: the median over the keyframes at which the
// run begins, where vision has not drifted yet, and one that is off does not decide. A keyframe
// whose height contradicts that (99.9 %) begins another run: a lift, another floor, or a map that
// is tilted, where many heights together would tear it.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "backend/core/map/map.h"

namespace gw::backend {

class FloorLevels {
 public:
  // T_BC: of the camera, whose poses the map has. The map must live as long as this.
  FloorLevels(const Map& map, const SE3& T_BC);

  struct Height {
    double z_W = 0;    // m, where the body of a keyframe should be
    double sigma = 0;  // m, > 0
  };
  // Empty: DR tells no height of this keyframe.
  std::optional<Height> Of(KeyframeId id) const;

 private:
  struct Run {
    std::vector<double> begin;  // the levels of its first keyframes, m; in any order
    double level = 0;           // m
  };

  const Map& map_;
  std::map<KeyframeId, KeyframeId> run_of_;  // by the first of it
  std::map<KeyframeId, Run> runs_;
};

}  // namespace gw::backend

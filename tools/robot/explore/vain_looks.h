// From how near unknown cells were looked at in vain: they were in view long enough to be seen, and
// were not (glass, a floor without texture, the shadow of a thing, what stands there and has no
// outline yet). Another look is expected to show them only from half as far (unseen_floor.h), so
// that a cell is looked at three times at most.
//
// Every image is a look, also those that are taken on the way. Kept by cell of W: a correction of
// the map that moves floor by more than a cell moves it from under them, and it is looked at again,
// as new floor is.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "common/core/time.h"
#include "tools/robot/explore/sight_rays.h"
#include "tools/robot/floorplan/floor_map.h"

namespace gw::explore {

class VainLooks {
 public:
  // A floor map has come, with images up to `images_to`; glances: SightRays::Glances on it from
  // where the robot is. What was in view in every floor map for kLongEnoughS was looked at; one
  // without a newer image shows nothing, whatever is in view: vision does not know the place.
  void Watch(const floorplan::FloorMap& map, const std::vector<Glance>& glances, Utime images_to);

  // A look is over that was long enough by itself.
  void Add(const floorplan::FloorMap& map, const std::vector<Glance>& glances);

  // For every cell of the map the least range (m); kNeverLookedAt where there was none.
  std::vector<float> On(const floorplan::FloorMap& map) const;

  // Three images at 5 Hz; two that agree make a cell known.
  static constexpr double kLongEnoughS = 0.6;

 private:
  using Cell = std::pair<int, int>;  // y, x in W
  struct InView {
    Utime since;
    float range_m = 0;  // the largest since then
  };

  std::map<Cell, float> least_m_;
  std::map<Cell, InView> in_view_;
  Utime images_to_;
};

}  // namespace gw::explore

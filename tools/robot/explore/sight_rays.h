// What a look from a place would show of a floor map, and which frontiers it looks past.
//
// A ray of sight goes over free floor, enters what is unknown only where it is still to be seen and
// near enough for that (unseen_floor.h), and ends at all else or at the range. What lies behind
// counts as seen until something known is met again: nobody knows better.
#pragma once

#include <vector>

#include "tools/robot/explore/unseen_floor.h"
#include "tools/robot/floorplan/waypoints.h"

namespace gw::explore {

// An unknown cell that is in view.
struct Glance {
  int cell = 0;       // of the floor map
  float range_m = 0;  // from the robot's centre
};

class SightRays {
 public:
  // `floor` must outlive it.
  explicit SightRays(const UnseenFloor& floor) : floor_(floor) {}

  // Area to be seen, m^2, that a look from there would show.
  double UnseenFrom(const floorplan::Waypoint& place) const;

  // Does `p`, the centre of a free cell, lie in view over free floor?
  bool Sees(const floorplan::Waypoint& place, const Eigen::Vector2d& p) const;

  // What a look from there must show, if there is floor: the first kGlanceM of what it would show
  // beyond the free floor. Not empty where UnseenFrom is not 0.
  std::vector<Glance> Glances(const floorplan::Waypoint& place) const;

  static constexpr double kGlanceM = 0.3;

 private:
  enum class Kind { kFree, kOpen, kEnd };
  Kind KindOf(const Eigen::Vector2i& cell, double range) const;
  // Calls take(cell, range) for every cell to be seen that a ray meets, until it says no.
  template <typename Take>
  void Follow(const floorplan::Waypoint& place, double turn, const Take& take) const;

  const UnseenFloor& floor_;
};

}  // namespace gw::explore

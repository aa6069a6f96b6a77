// Where to stand and where to look, to see past frontiers: what is to be seen against the way there
// (Gonzalez-Banos and Latombe, "Navigation strategies for exploring indoor environments", IJRR
// 2002).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/robot/explore/unseen_floor.h"
#include "tools/robot/floorplan/waypoints.h"

namespace gw::explore {

struct View {
  floorplan::Waypoint place;
  double unseen_m2 = 0;  // that a look from there would show, if nothing stood in it
  double way_m = 0;      // from where the robot is
};

struct ViewSearch {
  double clearance_m = 0;  // of places to stand and of ways there, from cells that are not free
  std::vector<Eigen::Vector2d> barred;  // no view is nearer to one of these than kBarredM
};
inline constexpr double kBarredM = 0.4;

// Of a look that shows so much, after such a way: the time that it takes is that of the way, at
// 0.35 m/s, and of turning, standing and looking, as long as 1.5 m of way.
double ValueOf(double unseen_m2, double way_m);

// The view of the largest value for every frontier that the robot, now at `from`, can look past
// from a place that it can reach; nearest first.
std::vector<View> FindViews(const UnseenFloor& floor, const Eigen::Vector2d& from,
                            const ViewSearch& search);

}  // namespace gw::explore

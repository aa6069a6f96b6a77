// In which order to go to several views, so that the way through all of them is short: as the
// global tours of Zhou et al., "FUEL: Fast UAV exploration using incremental frontier structure and
// hierarchical planning", RA-L 2021, with an exact search over the nearest ones.
#pragma once

#include <vector>

#include "tools/robot/explore/views.h"

namespace gw::explore {

inline constexpr int kMostInTour = 8;

// The index of the view to go to first, so that the way from `begin` through the nearest
// kMostInTour views, in any order, is the shortest. first_m: for each view the way to it, or what
// going there first is to count for. Precondition: there are views, nearest first; clearance_m as
// they were found.
int FirstOfTour(const floorplan::FloorMap& map, const std::vector<View>& views,
                const std::vector<double>& first_m, double clearance_m);

// The index at which the shortest way through all begins: first_m to the one that is first, then
// way_m[i][j] from i to j. At most 15.
int FirstOfShortest(const std::vector<double>& first_m,
                    const std::vector<std::vector<double>>& way_m);

}  // namespace gw::explore

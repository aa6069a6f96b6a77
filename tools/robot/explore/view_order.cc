#include "tools/robot/explore/view_order.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/robot/explore/way_lengths.h"

namespace gw::explore {
namespace {

constexpr double kNoWayM = 1e4;  // to a place that is cut off: last

}  // namespace

// Held and Karp, "A dynamic programming approach to sequencing problems", 1962, from the end: the
// shortest way from i through a set of others.
int FirstOfShortest(const std::vector<double>& first_m,
                    const std::vector<std::vector<double>>& way_m) {
  const size_t n = first_m.size();
  const size_t sets = size_t{1} << n;
  std::vector<std::vector<double>> rest(n, std::vector<double>(sets, 0));
  for (size_t set = 1; set < sets; ++set) {
    for (size_t from = 0; from < n; ++from) {
      if ((set >> from & 1) != 0) continue;
      double best = std::numeric_limits<double>::infinity();
      for (size_t to = 0; to < n; ++to) {
        if ((set >> to & 1) == 0) continue;
        best = std::min(best, way_m[from][to] + rest[to][set & ~(size_t{1} << to)]);
      }
      rest[from][set] = best;
    }
  }
  size_t first = 0;
  const auto length = [&](size_t i) {
    return first_m[i] + rest[i][(sets - 1) & ~(size_t{1} << i)];
  };
  for (size_t i = 1; i < n; ++i) {
    if (length(i) < length(first)) first = i;
  }
  return static_cast<int>(first);
}

int FirstOfTour(const floorplan::FloorMap& map, const std::vector<View>& views,
                const std::vector<double>& first_m, double clearance_m) {
  const size_t n = std::min<size_t>(views.size(), kMostInTour);
  std::vector<std::vector<double>> way(n, std::vector<double>(n, 0));
  for (size_t i = 0; i + 1 < n; ++i) {
    const std::vector<float> length = WayLengths(map, views[i].place.position, clearance_m);
    for (size_t j = i + 1; j < n; ++j) {
      const Eigen::Vector2i cell = map.CellOf(views[j].place.position);
      const double there = length[map.index(cell.x(), cell.y())];
      way[i][j] = way[j][i] = std::isfinite(there) ? there : kNoWayM;
    }
  }
  return FirstOfShortest({first_m.begin(), first_m.begin() + static_cast<ptrdiff_t>(n)}, way);
}

}  // namespace gw::explore

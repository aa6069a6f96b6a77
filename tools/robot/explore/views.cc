#include "tools/robot/explore/views.h"

#include <algorithm>
#include <cmath>

#include "tools/robot/explore/looks.h"
#include "tools/robot/explore/sight_rays.h"
#include "tools/robot/explore/way_lengths.h"

namespace gw::explore {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using floorplan::FloorMap;
using floorplan::Waypoint;

constexpr double kPlacesApartM = 0.2;  // places that are tried for a frontier
constexpr double kLookWayM = 1.5;      // a look costs as much as this way

class Searcher {
 public:
  Searcher(const FloorMap& map, const Vector2d& from, const ViewSearch& search)
      : map_(map),
        search_(search),
        from_(from),
        open_(OpenCells(map)),
        way_(WayLengths(map, from, search.clearance_m)),
        rays_(map, open_, search.looks, search.sight),
        most_m2_(search.sight.half_angle * search.sight.max_range_m * search.sight.max_range_m) {}

  // Its value is 0 when there is none.
  View BestFor(const Frontier& frontier) const {
    View best;
    Try(map_.CellOf(from_), frontier, &best);
    const double reach = search_.sight.max_range_m;
    const Vector2i low = map_.CellOf(frontier.middle - Vector2d::Constant(reach));
    const Vector2i high = map_.CellOf(frontier.middle + Vector2d::Constant(reach));
    const int apart = std::max(1, static_cast<int>(std::lround(kPlacesApartM / map_.resolution)));
    for (int y = low.y(); y <= high.y(); y += apart) {
      for (int x = low.x(); x <= high.x(); x += apart) Try({x, y}, frontier, &best);
    }
    return best;
  }

 private:
  void Try(const Vector2i& cell, const Frontier& frontier, View* best) const {
    if (!map_.InMap(cell.x(), cell.y())) return;
    const double way = way_[map_.index(cell.x(), cell.y())];
    if (!std::isfinite(way) || ValueOf(most_m2_, way) <= best->value) return;
    View view;
    view.place.position = map_.CentreOf(cell.x(), cell.y());
    if (Barred(view.place.position)) return;
    const Vector2d ahead = frontier.middle - view.place.position;
    view.place.yaw = std::atan2(ahead.y(), ahead.x());
    if (!rays_.LooksPast(view.place, frontier.middle)) return;
    view.way_m = way;
    view.unseen_m2 = rays_.UnseenFrom(view.place);
    view.value = ValueOf(view.unseen_m2, view.way_m);
    if (view.value > best->value) *best = view;
  }

  bool Barred(const Vector2d& p) const {
    return std::any_of(search_.barred.begin(), search_.barred.end(),
                       [&p](const Vector2d& b) { return (b - p).norm() < kBarredM; });
  }

  const FloorMap& map_;
  const ViewSearch& search_;
  Vector2d from_;
  std::vector<uint8_t> open_;
  std::vector<float> way_;
  SightRays rays_;
  double most_m2_;
};

}  // namespace

double ValueOf(double unseen_m2, double way_m) {
  return unseen_m2 / (kLookWayM + way_m);
}

std::vector<View> FindViews(const FloorMap& map, const Vector2d& from, const ViewSearch& search) {
  std::vector<View> views;
  if (map.occupied.empty()) return views;
  const Searcher searcher(map, from, search);
  for (const Frontier& frontier : FindFrontiers(map, GivenUp(search.looks), search.least_m)) {
    const View view = searcher.BestFor(frontier);
    if (view.value > 0) views.push_back(view);
  }
  std::stable_sort(views.begin(), views.end(),
                   [](const View& a, const View& b) { return a.value > b.value; });
  return views;
}

}  // namespace gw::explore

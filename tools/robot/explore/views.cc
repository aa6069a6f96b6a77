#include "tools/robot/explore/views.h"

#include <algorithm>
#include <cmath>

#include "tools/robot/explore/frontiers.h"
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
  Searcher(const UnseenFloor& floor, const Vector2d& from, const ViewSearch& search)
      : floor_(floor),
        search_(search),
        from_(from),
        way_(WayLengths(floor.map, from, search.clearance_m)),
        rays_(floor),
        most_m2_(floor.sight.half_angle * floor.sight.max_range_m * floor.sight.max_range_m) {}

  // It shows nothing when there is none.
  View BestFor(const Frontier& frontier) const {
    Best best;
    Try(floor_.map.CellOf(from_), frontier, &best);
    const double reach = floor_.sight.max_range_m;
    const Vector2i low = floor_.map.CellOf(frontier.middle - Vector2d::Constant(reach));
    const Vector2i high = floor_.map.CellOf(frontier.middle + Vector2d::Constant(reach));
    const int apart =
        std::max(1, static_cast<int>(std::lround(kPlacesApartM / floor_.map.resolution)));
    for (int y = low.y(); y <= high.y(); y += apart) {
      for (int x = low.x(); x <= high.x(); x += apart) Try({x, y}, frontier, &best);
    }
    return best.view;
  }

 private:
  struct Best {
    View view;
    double value = 0;
  };

  void Try(const Vector2i& cell, const Frontier& frontier, Best* best) const {
    const FloorMap& map = floor_.map;
    if (!map.InMap(cell.x(), cell.y())) return;
    const double way = way_[map.index(cell.x(), cell.y())];
    if (!std::isfinite(way) || ValueOf(most_m2_, way) <= best->value) return;
    View view;
    view.place.position = map.CentreOf(cell.x(), cell.y());
    if (Barred(view.place.position)) return;
    const Vector2d ahead = frontier.middle - view.place.position;
    view.place.yaw = std::atan2(ahead.y(), ahead.x());
    if (!rays_.Sees(view.place, frontier.middle)) return;
    view.way_m = way;
    view.unseen_m2 = rays_.UnseenFrom(view.place);
    const double value = ValueOf(view.unseen_m2, view.way_m);
    if (value > best->value) *best = {view, value};
  }

  bool Barred(const Vector2d& p) const {
    return std::any_of(search_.barred.begin(), search_.barred.end(),
                       [&p](const Vector2d& b) { return (b - p).norm() < kBarredM; });
  }

  const UnseenFloor& floor_;
  const ViewSearch& search_;
  Vector2d from_;
  std::vector<float> way_;
  SightRays rays_;
  double most_m2_;
};

}  // namespace

double ValueOf(double unseen_m2, double way_m) {
  return unseen_m2 / (kLookWayM + way_m);
}

std::vector<View> FindViews(const UnseenFloor& floor, const Vector2d& from,
                            const ViewSearch& search) {
  std::vector<View> views;
  if (floor.map.occupied.empty()) return views;
  const Searcher searcher(floor, from, search);
  for (const Frontier& frontier : FindFrontiers(floor)) {
    const View view = searcher.BestFor(frontier);
    if (view.unseen_m2 > 0) views.push_back(view);
  }
  std::stable_sort(views.begin(), views.end(),
                   [](const View& a, const View& b) { return a.way_m < b.way_m; });
  return views;
}

}  // namespace gw::explore

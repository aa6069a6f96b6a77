// What stands in the way now and is not in the map: OBSTACLES on the floor map.
//
// The walls of the map are seen as well, displaced by the noise of depth and pose. An obstacle that
// is nearer to one of them than the clearance with which ways pass walls is taken for that wall.
//
// Of what it stood before, the planner remembers more than gw-grid does: Remember() keeps what is
// in the way now until Forget(), so that a robot that tries another way does not come back to a way
// that was blocked only because it does not see it any more.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "common/contract/grid.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/robot/floorplan/planner.h"
#include "tools/robot/navigate/robot_pose.h"

namespace gw::navigate {

class ObstacleLayer {
 public:
  // known_m: obstacles nearer to an occupied cell of the map are that cell.
  ObstacleLayer(const floorplan::FloorMap& map, double known_m);

  // Another map of the same floor; what is remembered stays, as far as it lies in it.
  void SetMap(const floorplan::FloorMap& map);

  // at: the robot when the view's image was taken. The view replaces the one before.
  void See(const ObstacleView& view, const RobotPose& at);

  bool HasSeen() const { return view_utime_.has_value(); }
  // So far the floor ahead is seen to be free, m from B: 0 when blind, or when the newest view is
  // older than kStale. Empty when there never was a view: nobody looks.
  std::optional<double> SeenAhead(Utime now) const;

  // Distance (m) from a place to the edge of the nearest obstacle's cell; `limit` where none is
  // nearer.
  double DistanceTo(const Eigen::Vector2d& p, double limit) const;

  // Of the points of a leg from `begin` on, the first that comes nearer than `radius` to an
  // obstacle, no farther than `points` on. Empty: the way is free.
  std::optional<size_t> FirstBlocked(const floorplan::Leg& leg, size_t begin, size_t points,
                                     double radius) const;

  // The map with what is in the way now and what is remembered.
  floorplan::FloorMap On(const floorplan::FloorMap& map) const;

  void Remember();
  void Forget();

  static constexpr DurationUs kStale = Milliseconds(1000);

 private:
  double known_m_;
  floorplan::FloorMap map_;
  std::vector<float> distance_;  // to the map's occupied cells
  std::vector<Eigen::Vector2d> obstacles_;
  std::vector<uint8_t> remembered_;  // cells of the map
  std::optional<Utime> view_utime_;
  double half_cell_m_ = 0;
  double seen_ahead_m_ = 0;
};

}  // namespace gw::navigate

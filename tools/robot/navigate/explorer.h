// Explores: drives until the robot's own floor map (GRID) has no frontier left that it could look
// past, then back to where it began.
//
// It looks around once where it begins. Then, over and over: for every frontier
// (explore/frontiers.h) the view that shows most for the way there (explore/views.h); of these the
// one with which the shortest way through the nearest of them begins (explore/view_order.h); the
// way there over known free cells only, as the navigator drives it, with its recovery behaviours; a
// look. Every image is a look, also on the way: what was in view long enough and was not seen is
// looked at again from half as far only, and given up at last (explore/vain_looks.h), and a view
// that the navigator could not reach is barred. On the way it searches again whenever the floor map
// has changed: it leaves the view it has when most of what was to be seen there is seen already or
// was looked at in vain, or when beginning with another makes the way through all kKeepM shorter.
//
// The floor around the robot where it is put down, nearer than the camera sees, is taken for free
// where floor is seen behind it (explore/blind_ring.h), and is still to be seen: the next drive
// begins there, on what GRID has. Nothing else that is unknown is entered.
//
// The frame M of its poses is W.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/config/navigate_config.h"
#include "common/core/result.h"
#include "tools/robot/explore/sight.h"
#include "tools/robot/explore/unseen_floor.h"
#include "tools/robot/explore/vain_looks.h"
#include "tools/robot/explore/views.h"
#include "tools/robot/navigate/driver.h"
#include "tools/robot/navigate/floor_tiles.h"
#include "tools/robot/navigate/navigator.h"

namespace gw::navigate {

class Explorer : public Driver {
 public:
  Explorer(const NavigateConfig& config, const explore::Sight& sight);

  void Push(const std::optional<RobotPose>& pose) override;
  bool See(const ObstacleView& view) override { return navigator_.See(view); }
  void Sense(const ContactFlags& contact) override { navigator_.Sense(contact); }
  void Take(const GridUpdate& update, Utime now) override;
  Output Update(Utime now) override;

  bool finished() const override { return phase_ == Phase::kFinished; }
  // It is back where it began, and no frontier is left that it could look past.
  bool succeeded() const override { return why_not_.empty(); }
  std::string Summary() const override;
  std::string NameOf(int stop) const override;
  const floorplan::Waypoint& place(int stop) const override { return navigator_.place(stop); }
  int waypoint(int) const override { return -1; }
  int num_stops() const override { return navigator_.num_stops(); }
  const floorplan::Leg& leg() const override { return navigator_.leg(); }
  PoseState pose_state() const override { return navigator_.pose_state(); }
  std::string waits_for() const override { return waits_for_; }

  // Frontiers that it looked past, there or on the way.
  int num_explored() const { return num_explored_; }
  // Those that are in the map now; when it has finished: out of reach or not to be seen past.
  int num_left() const;
  // The floor map as it drives on it.
  const floorplan::FloorMap& map() const { return map_; }

  static constexpr double kKeepM = 3;

 private:
  enum class Phase { kWait, kLookAround, kLook, kGo, kReturn, kFinished };
  struct Found {
    std::vector<explore::View> views;  // nearest first
    double clearance_m = 0;            // of the ways there
  };

  void BringMapUpToDate();
  void WatchFloor();
  explore::UnseenFloor Unseen() const;
  void Await(Output* out);
  void TakeEvent(Utime now, const Event& event, Output* out);
  bool Looks(Utime now);
  void LookAndGoOn(Utime now, Output* out);
  void Reconsider(Utime now);
  void StopAndLook(Utime now);
  bool Enclosed() const;
  std::array<double, 2> Clearances() const;
  Found FindViews(const explore::UnseenFloor& floor) const;
  int FirstOf(const Found& found) const;
  void GoTo(const Found& found, int view);
  void Return();
  void Finish(const std::string& why_not, Output* out);

  NavigateConfig config_;
  explore::Sight sight_;
  Navigator navigator_;
  FloorTiles tiles_;
  bool tiles_changed_ = false;
  std::optional<Utime> grid_came_;
  Utime images_to_;           // in the floor map that came last,
  bool watched_ = true;       // and this is done with it
  floorplan::FloorMap seen_;  // as GRID has it
  floorplan::FloorMap map_;   // with what is taken for free, and what it bumped into
  std::vector<Eigen::Vector2d> assumed_free_;
  explore::VainLooks vain_;
  std::vector<Eigen::Vector2d> barred_;

  Phase phase_ = Phase::kWait;
  std::optional<RobotPose> pose_;
  std::optional<Utime> began_;
  std::optional<floorplan::Waypoint> home_;
  explore::View target_;
  std::optional<explore::View> looked_from_;  // it stands there and looks
  Utime arrived_;                             // where it stands
  Utime reconsidered_;
  int num_explored_ = 0;
  std::string waits_for_;
  std::string why_not_;  // it did not succeed; empty: it did
};

}  // namespace gw::navigate

#include "tools/robot/navigate/explorer.h"

#include <algorithm>
#include <cmath>

#include "tools/robot/explore/blind_ring.h"
#include "tools/robot/explore/frontiers.h"
#include "tools/robot/explore/sight_rays.h"
#include "tools/robot/explore/view_order.h"
#include "tools/robot/explore/way_lengths.h"
#include "tools/robot/floorplan/planner.h"

namespace gw::navigate {
namespace {

using explore::View;
using floorplan::FloorMap;

constexpr double kGridSilenceS = 5;    // gw-grid sends twice a second what images tell
constexpr double kReconsiderS = 1.0;   // between two searches on the way
constexpr double kMostlySeen = 0.3;    // of what was to be seen is left: the view is not worth it
constexpr double kNearlyThereM = 0.4;  // no other view is taken any more
constexpr double kSameViewM = 0.5;     // views that are nearer to each other count as one
constexpr double kTightM = 0.02;       // clearance where nothing is left with the configured one
constexpr double kRingMarginM = 0.15;  // beyond where the camera begins to see the floor

// What a navigator knows of the floor before the first GRID.
FloorMap UnknownFloor() {
  FloorMap map;
  map.width = map.height = 1;
  map.resolution = 0.05;
  map.occupied = {0};
  map.unknown = {1};
  return map;
}

}  // namespace

Explorer::Explorer(const NavigateConfig& config, const explore::Sight& sight)
    : config_(config), sight_(sight), navigator_(config, UnknownFloor()) {}

void Explorer::Push(const std::optional<RobotPose>& pose) {
  pose_ = pose;
  navigator_.Push(pose);
}

void Explorer::Take(const GridUpdate& update, Utime now) {
  tiles_changed_ = tiles_.Take(update) || tiles_changed_;
  if (!tiles_.empty()) grid_came_ = now;
  images_to_ = update.utime;
  watched_ = false;
}

void Explorer::BringMapUpToDate() {
  if (!tiles_changed_) return;
  tiles_changed_ = false;
  map_ = seen_ = tiles_.Map();
  for (const Eigen::Vector2d& p : assumed_free_) {
    const Eigen::Vector2i cell = map_.CellOf(p);
    if (map_.InMap(cell.x(), cell.y())) map_.unknown[map_.index(cell.x(), cell.y())] = 0;
  }
  navigator_.SetMap(map_);
  map_ = navigator_.map();
}

explore::UnseenFloor Explorer::Unseen() const {
  explore::UnseenFloor floor =
      explore::FindUnseenFloor(seen_, vain_.On(seen_), sight_, config_.robot_radius_m);
  floor.map = map_;
  return floor;
}

// What of the floor is in view now, and is it seen?
void Explorer::WatchFloor() {
  if (watched_ || !pose_ || !home_) return;
  watched_ = true;
  const explore::UnseenFloor floor = Unseen();
  vain_.Watch(map_, explore::SightRays(floor).Glances({pose_->position, pose_->yaw}), images_to_);
}

Driver::Output Explorer::Update(Utime now) {
  Output out;
  if (finished()) return out;
  if (!began_) began_ = now;
  if ((now - grid_came_.value_or(*began_)).seconds() > kGridSilenceS) {
    Await(&out);
    return out;
  }
  if (!grid_came_) return out;
  if (!waits_for_.empty()) {
    waits_for_.clear();
    out.events.push_back({EventKind::kResumed, num_stops(), pose_.value_or(RobotPose{}), ""});
  }
  BringMapUpToDate();
  WatchFloor();
  if (phase_ == Phase::kWait) {
    navigator_.LookAround();
    phase_ = Phase::kLookAround;
  }
  const Output moved = navigator_.Update(now);
  out.speed = moved.speed;
  for (const Event& event : moved.events) TakeEvent(now, event, &out);
  if (finished() || !pose_ || navigator_.held()) return out;
  if (phase_ == Phase::kLook) {
    LookAndGoOn(now, &out);
  } else if (phase_ == Phase::kGo || phase_ == Phase::kReturn) {
    Reconsider(now);
  }
  return out;
}

void Explorer::Await(Output* out) {
  if (!waits_for_.empty()) return;
  waits_for_ = "no floor map: GRID does not come, is gw-grid running?";
  out->events.push_back({EventKind::kHeld, num_stops(), pose_.value_or(RobotPose{}), waits_for_});
}

void Explorer::TakeEvent(Utime now, const Event& event, Output* out) {
  if (event.kind == EventKind::kFinished) return;  // one stop of many
  out->events.push_back(event);
  // Other views, and other ways to them, may be nearer now.
  if (event.kind == EventKind::kBumped) map_ = navigator_.map();
  const bool reached = event.kind == EventKind::kReached;
  if (!reached && event.kind != EventKind::kUnreachable) return;
  if (phase_ == Phase::kReturn || (phase_ == Phase::kLookAround && !reached)) {
    const std::string what =
        phase_ == Phase::kReturn ? "did not come back where it began: " : "could not look around: ";
    return Finish(reached ? "" : what + event.reason, out);
  }
  if (phase_ == Phase::kGo && !reached) barred_.push_back(target_.place.position);
  looked_from_ = phase_ == Phase::kGo && reached ? std::optional(target_) : std::nullopt;
  phase_ = Phase::kLook;
  arrived_ = now;
}

// It stands: until the floor map holds an image from there. None is added while vision does not
// know the place: then nothing was looked at, and no other view is taken there.
bool Explorer::Looks(Utime now) {
  if (images_to_ >= arrived_) return false;
  if ((now - arrived_).seconds() < kGridSilenceS) return true;
  if (looked_from_) barred_.push_back(looked_from_->place.position);
  looked_from_.reset();
  return false;
}

// What was seen from where it stands is in the floor map: where next?
void Explorer::LookAndGoOn(Utime now, Output* out) {
  if (Looks(now)) return;
  if (!home_) {
    home_ = {pose_->position, pose_->yaw};
    assumed_free_ =
        explore::FreeByLookingOver(map_, pose_->position, sight_.min_range_m + kRingMarginM);
    tiles_changed_ = true;
    BringMapUpToDate();
  }
  if (looked_from_) {
    ++num_explored_;
    const explore::UnseenFloor floor = Unseen();
    const explore::SightRays rays(floor);
    // Also what it was to show, if it does not stand quite there: it does not come again for that.
    for (const floorplan::Waypoint& from :
         {floorplan::Waypoint{pose_->position, pose_->yaw}, looked_from_->place}) {
      vain_.Add(map_, rays.Glances(from));
    }
    looked_from_.reset();
  }
  reconsidered_ = now;
  const Found found = FindViews(Unseen());
  if (!found.views.empty()) return GoTo(found, FirstOf(found));
  if (num_explored_ == 0 && Enclosed()) {
    return Finish("enclosed where it stands: none of the floor that it sees can be driven to", out);
  }
  Return();
}

// Of ways and places: with the room that the configuration asks for, and without.
std::array<double, 2> Explorer::Clearances() const {
  return {config_.robot_radius_m + config_.clearance_m,
          config_.robot_radius_m + std::min(kTightM, config_.clearance_m)};
}

// To where it began, or, where that is nearer to something than it can drive, to the nearest place
// beside it that it can reach.
void Explorer::Return() {
  floorplan::Waypoint place = *home_;
  double clearance = config_.robot_radius_m;
  for (const double tried : Clearances()) {
    clearance = tried;
    const std::vector<float> way = explore::WayLengths(map_, pose_->position, clearance);
    double apart = floorplan::kMaxStopMove;
    for (int i = 0; i < static_cast<int>(way.size()); ++i) {
      const Eigen::Vector2d p = map_.CentreOf(i % map_.width, i / map_.width);
      if (!std::isfinite(way[i]) || (p - home_->position).norm() >= apart) continue;
      apart = (p - home_->position).norm();
      place.position = p;
    }
    if (apart < floorplan::kMaxStopMove) break;
  }
  navigator_.GoTo(place, clearance);
  phase_ = Phase::kReturn;
}

// There is no place, farther away than the robot is wide, that it can drive to.
bool Explorer::Enclosed() const {
  const std::vector<float> way =
      explore::WayLengths(map_, pose_->position, config_.robot_radius_m + kTightM);
  return std::none_of(way.begin(), way.end(), [this](float length) {
    return std::isfinite(length) && length > 2 * config_.robot_radius_m;
  });
}

Explorer::Found Explorer::FindViews(const explore::UnseenFloor& floor) const {
  Found found;
  explore::ViewSearch search;
  search.barred = barred_;
  for (const double clearance : Clearances()) {
    search.clearance_m = found.clearance_m = clearance;
    found.views = explore::FindViews(floor, pose_->position, search);
    if (!found.views.empty()) break;
  }
  return found;
}

// Which view to go to. The one that it is going to has an advantage: the way there is not turned
// round for a trifle.
int Explorer::FirstOf(const Found& found) const {
  std::vector<double> first_m;
  for (const View& view : found.views) {
    const double apart = (view.place.position - target_.place.position).norm();
    const bool same = phase_ == Phase::kGo && apart < kSameViewM;
    first_m.push_back(view.way_m - (same ? kKeepM : 0));
  }
  return explore::FirstOfTour(map_, found.views, first_m, found.clearance_m);
}

void Explorer::GoTo(const Found& found, int view) {
  target_ = found.views[view];
  navigator_.GoTo(target_.place, found.clearance_m);
  phase_ = Phase::kGo;
}

// On the way: is the view still worth it, or is there a better one?
void Explorer::Reconsider(Utime now) {
  if ((now - reconsidered_).seconds() < kReconsiderS) return;
  reconsidered_ = now;
  const explore::UnseenFloor floor = Unseen();
  const Found found = FindViews(floor);
  if (found.views.empty()) {
    // What was to be seen is seen. The look decides what comes next, from where it is.
    if (phase_ == Phase::kGo) {
      ++num_explored_;
      StopAndLook(now);
    }
    return;
  }
  if (phase_ == Phase::kReturn) return GoTo(found, FirstOf(found));
  const bool worth_it =
      explore::SightRays(floor).UnseenFrom(target_.place) >= kMostlySeen * target_.unseen_m2;
  if (worth_it && (target_.place.position - pose_->position).norm() < kNearlyThereM) return;
  const int first = FirstOf(found);
  const double apart = (found.views[first].place.position - target_.place.position).norm();
  num_explored_ += worth_it ? 0 : 1;
  if (!worth_it || apart >= kSameViewM) GoTo(found, first);
}

void Explorer::StopAndLook(Utime now) {
  navigator_.Drop();
  phase_ = Phase::kLook;
  arrived_ = now;
}

int Explorer::num_left() const {
  const explore::UnseenFloor floor =
      explore::FindUnseenFloor(seen_, {}, sight_, config_.robot_radius_m);
  return static_cast<int>(explore::FindFrontiers(floor).size());
}

void Explorer::Finish(const std::string& why_not, Output* out) {
  why_not_ = why_not;
  phase_ = Phase::kFinished;
  out->speed = {};
  out->events.push_back({EventKind::kFinished, num_stops(), pose_.value_or(RobotPose{}), ""});
}

std::string Explorer::Summary() const {
  std::string text = "explored: " + std::to_string(num_explored_) + " frontiers, " +
                     std::to_string(num_left()) + (finished() ? " unreachable" : " left");
  if (!why_not_.empty()) text += "; " + why_not_;
  return text;
}

std::string Explorer::NameOf(int stop) const {
  if (stop == 0) return "where it began";
  if (phase_ == Phase::kReturn || phase_ == Phase::kFinished) return "back where it began";
  return "view " + std::to_string(stop);
}

}  // namespace gw::navigate

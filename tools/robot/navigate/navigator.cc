#include "tools/robot/navigate/navigator.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "tools/robot/floorplan/planner.h"

namespace gw::navigate {
namespace {

using floorplan::FloorMap;
using floorplan::Leg;
using floorplan::Waypoint;

constexpr double kArrivedM = 0.08;     // from the end of the leg
constexpr double kAlignedRad = 0.05;   // to the stop's heading
constexpr double kOffLegM = 0.5;       // the pose jumped, or something pushed: plan anew
constexpr double kBackOffM = 0.25;     // after a contact,
constexpr double kBackOffSpeed = 0.1;  // m/s
constexpr double kBackOffMaxS = 4;     // also when it does not move
constexpr double kObstacleM = 0.1;     // radius of what was bumped into
constexpr double kTightM = 0.02;       // clearance to walls of stops that are close to one
constexpr double kSteadyS = 0.3;       // without a reason to stand, before it goes on
constexpr double kProgressM = 0.05;    // nearer along the way counts as progress

void MarkDisc(const Eigen::Vector2d& centre, double radius, FloorMap* map) {
  const Eigen::Vector2i low = map->CellOf(centre - Eigen::Vector2d::Constant(radius));
  const Eigen::Vector2i high = map->CellOf(centre + Eigen::Vector2d::Constant(radius));
  for (int y = std::max(0, low.y()); y <= std::min(map->height - 1, high.y()); ++y) {
    for (int x = std::max(0, low.x()); x <= std::min(map->width - 1, high.x()); ++x) {
      if ((map->CentreOf(x, y) - centre).norm() <= radius) map->occupied[map->index(x, y)] = 1;
    }
  }
}

}  // namespace

const char* EventName(EventKind kind) {
  switch (kind) {
    case EventKind::kLeg:
      return "leg";
    case EventKind::kReached:
      return "reached";
    case EventKind::kUnreachable:
      return "unreachable";
    case EventKind::kHeld:
      return "held";
    case EventKind::kResumed:
      return "resumed";
    case EventKind::kBumped:
      return "bumped";
    case EventKind::kFinished:
      return "finished";
  }
  return "";
}

Navigator::Stop Navigator::MakeStop(const Waypoint& given) const {
  Stop stop{given, given, config_.robot_radius_m + config_.clearance_m};
  const auto move = [&] {
    stop.aim = floorplan::MoveStopsFromWalls(map_, {given}, stop.clearance_m).front();
    return (stop.aim.position - given.position).norm();
  };
  // A stop moved as far as that would hardly be reached.
  if (move() <= 0.5 * config_.reach_m) return stop;
  stop.clearance_m = config_.robot_radius_m + std::min(kTightM, config_.clearance_m);
  move();
  return stop;
}

Result<Navigator> Navigator::Create(const NavigateConfig& config, FloorMap map,
                                    const std::vector<Waypoint>& waypoints,
                                    const std::vector<int>& tour) {
  Navigator navigator(config, std::move(map));
  for (const int index : tour) navigator.stops_.push_back(navigator.MakeStop(waypoints[index]));
  if (navigator.stops_.empty()) return navigator;
  const Stop* from = nullptr;  // the last stop that can be visited
  for (size_t i = 0; i < tour.size(); ++i) {
    const Stop& to = navigator.stops_[i];
    std::vector<Waypoint> way = {to.aim};
    if (from != nullptr) way.insert(way.begin(), from->aim);
    const double clearance = std::min((from != nullptr ? *from : to).clearance_m, to.clearance_m);
    const floorplan::Tour visited = floorplan::PlanTour(navigator.map_, way, clearance);
    if (visited.refused.empty()) from = &to;
    for (const floorplan::RefusedStop& refused : visited.refused) {
      navigator.complaints_.push_back("waypoint " + std::to_string(tour[i]) +
                                      " of the tour cannot be visited: " + refused.why);
    }
  }
  if (navigator.complaints_.size() < tour.size()) return navigator;
  std::string text;
  for (const std::string& complaint : navigator.complaints_) {
    text += (text.empty() ? "" : "; ") + complaint;
  }
  return Error{ErrorCode::kBadData, text};
}

Navigator::Output Navigator::Update(Utime now) {
  Output out;
  if (finished()) {
    if (!told_finished_) Tell(EventKind::kFinished, "", &out);
    told_finished_ = true;
    return out;
  }
  verdict_ = guard_.Judge(pose_, now);
  const std::string why = WhyNotDriving();
  if (!why.empty()) {
    if (!held_) Tell(EventKind::kHeld, why, &out);
    held_ = true;
    last_bad_ = now;
    return out;
  }
  if (held_) {
    if ((now - last_bad_).seconds() < kSteadyS) return out;
    held_ = false;
    Tell(EventKind::kResumed, "", &out);
    phase_ = Phase::kPlan;
    progressed_.reset();
  }
  if ((contact_.bumper || contact_.cliff) && phase_ != Phase::kBackOff) BeginBackOff(now, &out);
  switch (phase_) {
    case Phase::kPlan:
      Plan(&out);
      break;
    case Phase::kFollow:
      Follow(&out);
      break;
    case Phase::kAlign:
      Align(now, &out);
      break;
    case Phase::kSettle:
      Settle(now, &out);
      break;
    case Phase::kBackOff:
      BackOff(now, &out);
      break;
  }
  out.speed.v *= verdict_.speed_share;
  out.speed.w *= verdict_.speed_share;
  if (!finished()) WatchProgress(now, &out);
  return out;
}

// Empty when it may drive.
std::string Navigator::WhyNotDriving() const {
  if (contact_.wheel_drop) return "lifted";
  if (verdict_.state == PoseState::kGood) return "";
  return std::string("pose ") + PoseStateName(verdict_.state);
}

void Navigator::Plan(Output* out) {
  const Stop& to = stops_[stop_];
  const double clearance =
      std::min(to.clearance_m, stop_ > 0 ? stops_[stop_ - 1].clearance_m : to.clearance_m);
  const Waypoint here{pose_->position, pose_->yaw};
  const Waypoint from = floorplan::MoveStopsFromWalls(map_, {here}, clearance).front();
  floorplan::Tour way = floorplan::PlanTour(map_, {from, to.aim}, clearance);
  if (!way.refused.empty()) return GoOn(EventKind::kUnreachable, way.refused.front().why, out);
  leg_ = std::move(way.legs.front());
  const double max_w = config_.max_turn_deg_s * std::numbers::pi / 180;
  pursuit_.emplace(leg_, floorplan::PursuitConfig{config_.max_speed_m_s, max_w});
  phase_ = Phase::kFollow;
  progressed_.reset();
  Tell(EventKind::kLeg, "", out);
}

void Navigator::Follow(Output* out) {
  if (pursuit_->DistanceToEnd(pose_->position) < kArrivedM) {
    phase_ = Phase::kAlign;
    return;
  }
  out->speed = pursuit_->Update(pose_->position, pose_->yaw);
  if (pursuit_->DistanceToLeg(pose_->position) > kOffLegM) {
    out->speed = {};
    phase_ = Phase::kPlan;
  }
}

void Navigator::Align(Utime now, Output* out) {
  const double error = floorplan::AngleTo(pose_->yaw, stops_[stop_].aim.yaw);
  if (std::abs(error) < kAlignedRad) {
    phase_ = Phase::kSettle;
    phase_began_ = now;
    return;
  }
  out->speed = floorplan::TurnBy(error, config_.max_turn_deg_s * std::numbers::pi / 180);
}

void Navigator::Settle(Utime now, Output* out) {
  if ((now - phase_began_).seconds() < config_.pause_s) return;
  const Waypoint& goal = stops_[stop_].given;
  if ((pose_->position - goal.position).norm() <= config_.reach_m &&
      std::abs(floorplan::AngleTo(pose_->yaw, goal.yaw)) <= config_.reach_rad) {
    return GoOn(EventKind::kReached, "", out);
  }
  if (++attempts_ >= kAttempts) return GoOn(EventKind::kUnreachable, "missed", out);
  phase_ = Phase::kPlan;
}

void Navigator::BeginBackOff(Utime now, Output* out) {
  Tell(EventKind::kBumped, contact_.bumper ? "bumper" : "cliff", out);
  if (++attempts_ >= kAttempts) return GoOn(EventKind::kUnreachable, "blocked", out);
  MarkDisc(pose_->position + (config_.robot_radius_m + 0.5 * kObstacleM) *
                                 Eigen::Vector2d(std::cos(pose_->yaw), std::sin(pose_->yaw)),
           kObstacleM, &map_);
  bumped_at_ = pose_->position;
  phase_ = Phase::kBackOff;
  phase_began_ = now;
}

void Navigator::BackOff(Utime now, Output* out) {
  out->speed.v = -kBackOffSpeed;
  if ((pose_->position - bumped_at_).norm() >= kBackOffM ||
      (now - phase_began_).seconds() >= kBackOffMaxS) {
    out->speed = {};
    phase_ = Phase::kPlan;
  }
}

void Navigator::WatchProgress(Utime now, Output* out) {
  const double left = pursuit_ ? pursuit_->Left() : 0;
  if (!progressed_ || left < nearest_m_ - kProgressM) {
    progressed_ = now;
    nearest_m_ = left;
  }
  if ((now - *progressed_).seconds() < config_.give_up_s + config_.pause_s) return;
  out->speed = {};
  GoOn(EventKind::kUnreachable, "comes no nearer", out);
}

void Navigator::GoOn(EventKind kind, const std::string& reason, Output* out) {
  Tell(kind, reason, out);
  num_unreachable_ += kind == EventKind::kUnreachable ? 1 : 0;
  ++stop_;
  attempts_ = 0;
  phase_ = Phase::kPlan;
  progressed_.reset();
}

void Navigator::Tell(EventKind kind, const std::string& reason, Output* out) const {
  out->events.push_back({kind, stop_, pose_.value_or(RobotPose{}), reason});
}

}  // namespace gw::navigate

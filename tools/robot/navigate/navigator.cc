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

constexpr double kArrivedM = 0.08;     // from the end of the leg, at most,
constexpr double kNearestM = 0.02;     // and no nearer than it can steer;
constexpr double kOfReach = 0.8;       // of what counts as reached: it rolls on a little
constexpr double kAlignedRad = 0.05;   // to the stop's heading
constexpr double kOffLegM = 0.5;       // the pose jumped, or something pushed: plan anew
constexpr double kBackOffM = 0.25;     // after a contact,
constexpr double kBackOffSpeed = 0.1;  // m/s
constexpr double kBackOffMaxS = 4;     // also when it does not move
constexpr double kObstacleM = 0.1;     // radius of what was bumped into
constexpr double kTightM = 0.02;       // clearance to walls of stops that are close to one
constexpr double kSteadyS = 0.3;       // without a reason to stand, before it goes on
constexpr double kProgressM = 0.05;    // nearer along the way counts as progress
constexpr double kAheadM = 1.5;        // of the way is watched for obstacles
constexpr double kStandOffM = 0.1;     // it stands so far before what it would touch
constexpr double kArcM = 0.4;          // of the way by the present command is watched,
constexpr double kArcStepM = 0.04;     // in such steps
constexpr double kCrawl = 0.05;        // m/s: slower is as good as standing
constexpr double kTurnOutOfWay = 0.5;  // rad/s
constexpr double kPatienceS = 4;       // before something that may walk on
constexpr double kReplanS = 0.5;       // between two plans around obstacles
constexpr int kMaxDetours = 60;        // for one stop: something is always in the way; as many
                                       // plans for other maps, if it comes no nearer between them
constexpr double kBrake = 0.8;         // m/s^2; a Kobuki can do 1.2
constexpr double kReactS = 0.4;        // from an image to the first braking: 0.1 s between two
                                       // views, 0.05 s to a command, 0.25 s to the motion
constexpr double kPassSlowlyM = 0.25;  // from the robot's edge to an obstacle: slower, down to
constexpr double kPassShare = 0.4;     // this share of the speed when it nearly touches
constexpr double kUnplacedS = 2.0;     // without a place in the map, before it looks around,
constexpr double kLookTurn = 0.5;      // rad/s,
constexpr double kMostLook = 13;       // rad: twice around, then somebody has to move it
constexpr double kPastS = 1.0;         // of poses is kept for late views
constexpr DurationUs kPoseGap = Milliseconds(60);  // between a view and the pose it is taken with

// The fastest speed from which the robot stops within d metres: v * t + v^2 / (2 a) = d.
double StoppingSpeed(double d) {
  if (d <= 0) return 0;
  return kBrake * (std::sqrt(kReactS * kReactS + 2 * d / kBrake) - kReactS);
}

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
  for (const int index : tour) {
    navigator.stops_.push_back(navigator.MakeStop(waypoints[index]));
    navigator.stops_.back().waypoint = index;
  }
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

void Navigator::SetStop(const Stop& stop) {
  if (finished()) {
    stops_.push_back(stop);
  } else {
    stops_[stop_] = stop;
  }
  told_finished_ = false;
  attempts_ = 0;
  detours_ = 0;
  replans_ = 0;
  moving_ = phase_ == Phase::kFollow;
  if (phase_ != Phase::kBackOff) phase_ = Phase::kPlan;
  progressed_.reset();
}

void Navigator::GoTo(const Waypoint& place, double clearance_m) {
  SetStop({place, place, clearance_m});
}

void Navigator::LookAround() {
  Stop stop;
  stop.look_around = true;
  if (pose_) stop.given = stop.aim = {pose_->position, pose_->yaw};
  SetStop(stop);
}

void Navigator::Drop() {
  if (!finished()) stops_.resize(stop_);
  if (phase_ == Phase::kFollow) phase_ = Phase::kPlan;
}

void Navigator::SetMap(FloorMap map) {
  map_ = std::move(map);
  for (const Eigen::Vector2d& p : bumped_into_) MarkDisc(p, kObstacleM, &map_);
  obstacles_.SetMap(map_);
  if (phase_ != Phase::kFollow) return;
  const std::vector<float> room = floorplan::DistanceToOccupied(map_, 2 * config_.robot_radius_m);
  const auto blocked = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2i cell = map_.CellOf(p);
    return !map_.InMap(cell.x(), cell.y()) || map_.Unknown(cell.x(), cell.y()) ||
           floorplan::DistanceAt(map_, room, p) < config_.robot_radius_m;
  };
  const auto ahead = leg_.begin() + static_cast<ptrdiff_t>(pursuit_->nearest());
  // Where the robot stands may be too near already: the way leads away from there.
  const auto first_free = std::find_if_not(ahead, leg_.end(), blocked);
  if (std::none_of(first_free, leg_.end(), blocked)) return;
  phase_ = Phase::kPlan;
  moving_ = true;
  ++replans_;
}

void Navigator::Push(const std::optional<RobotPose>& pose) {
  pose_ = pose;
  unplaced_ = !pose;
  if (!pose) return;
  if (!past_.empty() && pose->utime < past_.back().utime) past_.clear();
  past_.push_back(*pose);
  while ((past_.back().utime - past_.front().utime).seconds() > kPastS) past_.pop_front();
}

bool Navigator::See(const ObstacleView& view) {
  const auto apart = [&view](const RobotPose& p) { return std::abs((p.utime - view.utime).us); };
  const auto at = std::min_element(past_.begin(), past_.end(), [&](const auto& a, const auto& b) {
    return apart(a) < apart(b);
  });
  if (at == past_.end() || apart(*at) > kPoseGap.us) return false;
  obstacles_.See(view, *at);
  return true;
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
    if (!held_) held_since_ = now;
    held_ = true;
    last_bad_ = now;
    out.speed = LookForPlace(now);
    return out;
  }
  if (held_) {
    if ((now - last_bad_).seconds() < kSteadyS) return out;
    held_ = false;
    looked_ = 0;
    Tell(EventKind::kResumed, "", &out);
    phase_ = Phase::kPlan;
    progressed_.reset();
  }
  if ((contact_.bumper || contact_.cliff) && phase_ != Phase::kBackOff) BeginBackOff(now, &out);
  Drive(now, &out);
  out.speed.v *= verdict_.speed_share;
  out.speed.w *= verdict_.speed_share;
  if (!finished()) WatchProgress(now, &out);
  return out;
}

void Navigator::Drive(Utime now, Output* out) {
  switch (phase_) {
    case Phase::kPlan:
      return Plan(now, out);
    case Phase::kFollow:
      return Follow(now, out);
    case Phase::kAlign:
      return Align(now, out);
    case Phase::kSettle:
      return Settle(now, out);
    case Phase::kBlocked:
      return Blocked(now, out);
    case Phase::kBackOff:
      return BackOff(now, out);
    case Phase::kLook:
      return Look(out);
  }
}

// Dead reckoning is there, and a map is, but not where in it the robot stands, or not how well:
// another view may tell. A round robot can turn wherever it can stand.
floorplan::Speed Navigator::LookForPlace(Utime now) {
  const bool lost = unplaced_ || verdict_.state == PoseState::kUncertain;
  if (!lost || contact_.wheel_drop || looked_ > kMostLook) return {};
  if ((now - held_since_).seconds() < kUnplacedS) return {};
  looked_ += kLookTurn / kRateHz;
  return {0, kLookTurn};
}

// Empty when it may drive.
std::string Navigator::WhyNotDriving() const {
  if (contact_.wheel_drop) return "lifted";
  if (verdict_.state == PoseState::kGood) return "";
  return std::string("pose ") + PoseStateName(verdict_.state);
}

// From here to the stop. Where the stop itself is covered by an obstacle, to a place beside it that
// still counts as reached.
floorplan::Tour Navigator::WayOn(const FloorMap& map, double clearance) const {
  const Stop& to = stops_[stop_];
  const Waypoint here{pose_->position, pose_->yaw};
  const auto moved = floorplan::MoveStopsFromWalls(map, {here, to.aim}, clearance);
  const bool counts = (moved[1].position - to.given.position).norm() < 0.75 * config_.reach_m;
  return floorplan::PlanTour(map, {moved[0], counts ? moved[1] : to.aim}, clearance);
}

void Navigator::Plan(Utime now, Output* out) {
  const Stop& to = stops_[stop_];
  if (to.look_around) return BeginLook();
  if (replans_ > kMaxDetours) return GoOn(EventKind::kUnreachable, "blocked", out);
  const bool on_the_move = std::exchange(moving_, false) && HasRoomForArc();
  const double clearance =
      std::min(to.clearance_m, stop_ > 0 ? stops_[stop_ - 1].clearance_m : to.clearance_m);
  floorplan::Tour way = WayOn(map_, clearance);
  if (!way.refused.empty()) return GoOn(EventKind::kUnreachable, way.refused.front().why, out);
  progressed_.reset();
  if (!obstacles_.HasSeen()) return TakeLeg(std::move(way.legs.front()), on_the_move, out);
  if (!PlanAroundObstacles(now, on_the_move, out)) BeginBlocked(now, out);
}

// Around all that was in the way since the last stop: with the room that the configuration asks
// for, else closer, else on the way of the map if it touches nothing: at a stop in a corner the
// walls as they are seen now can leave less room than those of the map.
bool Navigator::PlanAroundObstacles(Utime now, bool on_the_move, Output* out) {
  planned_ = now;
  obstacles_.Remember();
  const FloorMap map = obstacles_.On(map_);
  const double close = config_.robot_radius_m + std::min(kTightM, config_.clearance_m);
  for (const double clearance : {stops_[stop_].clearance_m, close}) {
    floorplan::Tour way = WayOn(map, clearance);
    if (!way.refused.empty()) continue;
    TakeLeg(std::move(way.legs.front()), on_the_move, out);
    return true;
  }
  floorplan::Tour way = WayOn(map_, stops_[stop_].clearance_m);
  if (!way.refused.empty()) return false;
  Leg& leg = way.legs.front();
  if (obstacles_.FirstBlocked(leg, 0, leg.size(), config_.robot_radius_m)) return false;
  TakeLeg(std::move(leg), on_the_move, out);
  return true;
}

void Navigator::TakeLeg(Leg leg, bool on_the_move, Output* out) {
  leg_ = std::move(leg);
  const double max_w = config_.max_turn_deg_s * std::numbers::pi / 180;
  pursuit_.emplace(leg_, floorplan::PursuitConfig{config_.max_speed_m_s, max_w}, on_the_move);
  phase_ = Phase::kFollow;
  progressed_.reset();
  Tell(EventKind::kLeg, "", out);
}

void Navigator::Follow(Utime now, Output* out) {
  if (pursuit_->DistanceToEnd(pose_->position) < ArrivalRadius()) {
    phase_ = Phase::kAlign;
    return;
  }
  if (pursuit_->DistanceToLeg(pose_->position) > kOffLegM) {
    phase_ = Phase::kPlan;
    return;
  }
  const std::optional<double> free_way = FreeWay();
  if (free_way) {
    if ((now - planned_).seconds() >= kReplanS) {
      if (detours_ >= kMaxDetours) return GoOn(EventKind::kUnreachable, "blocked", out);
      if (PlanAroundObstacles(now, HasRoomForArc(), out)) {
        ++detours_;
        return Follow(now, out);
      }
    }
    if (StoppingSpeed(*free_way - kStandOffM) < kBackOffSpeed) return BeginBlocked(now, out);
  }
  const double limit = SpeedLimit(now, free_way);
  out->speed = pursuit_->Update(pose_->position, pose_->yaw, limit / config_.max_speed_m_s);
  AvoidOnArc(&out->speed);
}

// How near to the end of the leg it has to come. A leg that ends beside the stop, because the robot
// cannot stand there, leaves only the rest of what counts as reached.
double Navigator::ArrivalRadius() const {
  const double beside = (leg_.back() - stops_[stop_].given.position).norm();
  return std::clamp(kOfReach * (config_.reach_m - beside), kNearestM, kArrivedM);
}

// Beside something near it turns on the spot before it drives on another leg: an arc would cut the
// corner.
bool Navigator::HasRoomForArc() const {
  const double room = config_.robot_radius_m + kPassSlowlyM;
  return obstacles_.DistanceTo(pose_->position, room) >= room;
}

// The arc that the robot would drive is not quite the leg. Where it would touch something, it
// drives no faster than it can stop before that; if that is next to nothing, it turns on the spot.
void Navigator::AvoidOnArc(floorplan::Speed* speed) const {
  const double radius = config_.robot_radius_m;
  const double now = obstacles_.DistanceTo(pose_->position, radius + kArcM);
  if (speed->v <= 0 || now >= radius + kArcM) return;
  const double turn_per_m = speed->w / speed->v;
  double free = 0, yaw = pose_->yaw;
  Eigen::Vector2d p = pose_->position;
  for (; free < kArcM; free += kArcStepM) {
    yaw += kArcStepM * turn_per_m;
    p += kArcStepM * Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
    const double there = obstacles_.DistanceTo(p, radius);
    if (there < radius && there < now) break;
  }
  if (free >= kArcM) return;
  const double v = std::min(speed->v, StoppingSpeed(free - kArcStepM));
  if (v < kCrawl) {
    *speed = {0, std::copysign(kTurnOutOfWay, turn_per_m)};
  } else {
    *speed = {v, v * turn_per_m};
  }
}

// To the first point of the leg ahead where the robot would touch something; empty when there is
// none. Where the leg leads away from something that is too near already, it is free.
std::optional<double> Navigator::FreeWay() const {
  const double radius = config_.robot_radius_m;
  const size_t nearest = pursuit_->nearest();
  const double now = obstacles_.DistanceTo(pose_->position, radius);
  size_t begin = nearest;
  while (begin + 1 < leg_.size()) {
    const double there = obstacles_.DistanceTo(leg_[begin], radius);
    if (there >= radius || there < now) break;
    ++begin;
  }
  const auto blocked = obstacles_.FirstBlocked(
      leg_, begin, static_cast<size_t>(kAheadM / floorplan::kLegSpacing), radius);
  if (!blocked) return std::nullopt;
  return floorplan::kLegSpacing * static_cast<double>(*blocked - nearest);
}

// How fast it may drive along the leg: so that it can stop before what stands on it, within the
// floor that it sees, and slowly past what stands beside it (the last as in Macenski et al.,
// "Regulated pure pursuit for robot path tracking", Autonomous Robots 2023, section 3).
double Navigator::SpeedLimit(Utime now, std::optional<double> free_way) const {
  double limit = config_.max_speed_m_s;
  const std::optional<double> seen = obstacles_.SeenAhead(now);
  if (!seen) return limit;
  const double room = *seen - config_.robot_radius_m;
  limit = std::min(limit, std::max(config_.blind_speed_m_s, StoppingSpeed(room)));
  if (free_way) limit = std::min(limit, StoppingSpeed(*free_way - kStandOffM));
  const double beside =
      obstacles_.DistanceTo(pose_->position, config_.robot_radius_m + kPassSlowlyM) -
      config_.robot_radius_m;
  const double share = std::clamp(beside / kPassSlowlyM, kPassShare, 1.0);
  return std::max(kCrawl, std::min(limit, share * config_.max_speed_m_s));
}

void Navigator::BeginBlocked(Utime now, Output* out) {
  out->speed = {};
  phase_ = Phase::kBlocked;
  phase_began_ = now;
  Tell(EventKind::kBlocked, "", out);
}

void Navigator::Blocked(Utime now, Output* out) {
  if ((now - phase_began_).seconds() < kPatienceS) return;
  if (++attempts_ >= kAttempts) return GoOn(EventKind::kUnreachable, "blocked", out);
  obstacles_.Forget();
  if (PlanAroundObstacles(now, false, out)) return;
  if (!RoomBehind()) return BeginLook();
  phase_ = Phase::kBackOff;
  phase_began_ = now;
  bumped_at_ = pose_->position;
}

bool Navigator::RoomBehind() const {
  const FloorMap map = obstacles_.On(map_);
  const std::vector<float> distance = floorplan::DistanceToNotFree(map, 1.0);
  const Eigen::Vector2d back(-std::cos(pose_->yaw), -std::sin(pose_->yaw));
  return floorplan::DistanceAt(map, distance, pose_->position + kBackOffM * back) >
         config_.robot_radius_m;
}

// Once around, so that the next plan knows what stands at all sides.
void Navigator::BeginLook() {
  phase_ = Phase::kLook;
  turned_ = 0;
  last_yaw_ = pose_->yaw;
}

void Navigator::Look(Output* out) {
  turned_ += floorplan::AngleTo(last_yaw_, pose_->yaw);
  last_yaw_ = pose_->yaw;
  if (turned_ >= 2 * std::numbers::pi) {
    if (stops_[stop_].look_around) return GoOn(EventKind::kReached, "", out);
    phase_ = Phase::kPlan;
    return;
  }
  out->speed.w =
      stops_[stop_].look_around ? kLookTurn : config_.max_turn_deg_s * std::numbers::pi / 180;
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
  const Eigen::Vector2d ahead(std::cos(pose_->yaw), std::sin(pose_->yaw));
  bumped_into_.push_back(pose_->position + (config_.robot_radius_m + 0.5 * kObstacleM) * ahead);
  MarkDisc(bumped_into_.back(), kObstacleM, &map_);
  bumped_at_ = pose_->position;
  phase_ = Phase::kBackOff;
  phase_began_ = now;
}

void Navigator::BackOff(Utime now, Output* out) {
  out->speed.v = -kBackOffSpeed;
  if ((pose_->position - bumped_at_).norm() >= kBackOffM ||
      (now - phase_began_).seconds() >= kBackOffMaxS) {
    out->speed = {};
    if (obstacles_.HasSeen()) return BeginLook();
    phase_ = Phase::kPlan;
  }
}

void Navigator::WatchProgress(Utime now, Output* out) {
  const double left = pursuit_ ? pursuit_->Left() : 0;
  if (progressed_ && left < nearest_m_ - kProgressM) replans_ = 0;
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
  detours_ = 0;
  replans_ = 0;
  obstacles_.Forget();
  phase_ = Phase::kPlan;
  progressed_.reset();
}

std::string Navigator::Summary() const {
  return std::to_string(num_stops() - num_unreachable_) + " of " + std::to_string(num_stops()) +
         " stops reached";
}

std::string Navigator::NameOf(int stop) const {
  return "stop " + std::to_string(stop + 1) + " of " + std::to_string(num_stops()) + ", waypoint " +
         std::to_string(stops_[stop].waypoint);
}

void Navigator::Tell(EventKind kind, const std::string& reason, Output* out) const {
  out->events.push_back({kind, stop_, pose_.value_or(RobotPose{}), reason});
}

}  // namespace gw::navigate

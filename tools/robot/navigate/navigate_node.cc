#include "tools/robot/navigate/navigate_node.h"

#include <sstream>

#include "common/core/exit_code.h"
#include "common/wire/channels.h"
#include "common/wire/grid.h"

namespace gw::navigate {
namespace {

constexpr DurationUs kPeriod{1'000'000 / Navigator::kRateHz};

Result<floorplan::Waypoint> ParseStart(const std::string& text) {
  floorplan::Waypoint start;
  char comma = 0, comma2 = 0;
  std::istringstream in(text);
  std::string rest;
  if (!(in >> start.position.x() >> comma >> start.position.y() >> comma2 >> start.yaw) ||
      comma != ',' || comma2 != ',' || (in >> rest)) {
    return Error{ErrorCode::kInvalidArgument,
                 "--start: want X,Y,THETA on the map (m, rad), got `" + text + "`"};
  }
  return start;
}

}  // namespace

Result<std::unique_ptr<process::Node>> NavigateNode::Create(const RobotConfig& config,
                                                            const NavigateOptions& options) {
  if (options.laps < 1) return Error{ErrorCode::kInvalidArgument, "--laps: must be at least 1"};
  auto map = floorplan::LoadFloorMap(options.map);
  if (!map) return map.error();
  const auto waypoints = floorplan::LoadWaypoints(options.waypoints);
  if (!waypoints) return waypoints.error();
  const int num_waypoints = static_cast<int>(waypoints->size());
  std::vector<int> visit;
  if (!options.path.empty()) {
    auto order = floorplan::LoadVisitOrder(options.path, num_waypoints);
    if (!order) return order.error();
    visit = *std::move(order);
  }
  std::vector<int> tour = floorplan::StopsOfLaps(num_waypoints, std::move(visit), options.laps);
  floorplan::Waypoint start = (*waypoints)[tour.front()];
  if (!options.start.empty()) {
    const auto parsed = ParseStart(options.start);
    if (!parsed) return parsed.error();
    start = *parsed;
  }
  auto navigator = Navigator::Create(config.navigate, *std::move(map), *waypoints, tour);
  if (!navigator) {
    return Error{navigator.error().code, options.waypoints + ": " + navigator.error().message};
  }
  std::unique_ptr<NavigateNode> node(
      new NavigateNode(*std::move(navigator), std::move(tour), MapFromWorld(start), options.truth));
  if (!options.record.empty()) {
    auto record = RunRecord::Create(options.record);
    if (!record) return record.error();
    node->record_.emplace(*std::move(record));
  }
  return std::unique_ptr<process::Node>(std::move(node));
}

Result<Done> NavigateNode::Start(process::Shell& shell) {
  for (const std::string& complaint : navigator_.complaints()) {
    shell.log().Write(shell.Now(), process::Severity::kWarning, "navigate.waypoint",
                      {{"what", complaint}});
  }
  auto ok =
      shell.Listen<WheelSample>(wire::kWheel, [this](const WheelSample& sample, Utime received) {
        time_.Observe(sample.utime, received);
        navigator_.Sense(sample.contact);
      });
  if (!ok) return ok;
  ok =
      shell.Listen<ObstacleView>(wire::kObstacles, [this, &shell](const ObstacleView& view, Utime) {
        if (!navigator_.See(view)) shell.health().Count("OBSTACLES.without_pose");
      });
  if (!ok) return ok;
  if (truth_) {
    return shell.Listen<GroundTruth>(
        wire::kGroundTruth, [this](const GroundTruth& truth, Utime) { Take(OnMap(truth)); });
  }
  return shell.Listen<Pose>(wire::kPose, [this](const Pose& pose, Utime) {
    // Without a map W is O, which says nothing about where the robot is on the floor.
    Take(pose.has_map ? std::optional(OnMap(T_MW_, pose)) : std::nullopt);
  });
}

void NavigateNode::Take(const std::optional<RobotPose>& pose) {
  pose_ = pose;
  navigator_.Push(pose);
}

bool NavigateNode::Step(process::Shell& shell) {
  const Utime clock = shell.Now();
  if (updated_ && clock - *updated_ < kPeriod) return true;
  updated_ = clock;
  ReportHealth(shell);
  const auto now = time_.At(clock);
  if (!now) return true;  // no base yet
  const Navigator::Output out = navigator_.Update(*now);
  Command(*now, out.speed, shell);
  for (const Event& event : out.events) Tell(*now, event, shell);
  if (record_ && pose_ && pose_->utime > recorded_) {
    recorded_ = pose_->utime;
    record_->AddPose(*pose_);
  }
  return true;
}

void NavigateNode::Command(Utime now, const floorplan::Speed& speed, process::Shell& shell) {
  shell.Publish(wire::kBaseCommand,
                wire::Encode(BaseCommand{now, ++command_seq_, speed.v, speed.w}));
}

void NavigateNode::Tell(Utime now, const Event& event, process::Shell& shell) {
  if (event.kind == EventKind::kLeg) {
    if (record_) record_->AddLeg(event.stop, navigator_.leg());
    return;
  }
  std::ostringstream text;
  if (event.kind == EventKind::kFinished) {
    text << navigator_.num_stops() - navigator_.num_unreachable() << " of "
         << navigator_.num_stops() << " stops reached";
  } else {
    text << "stop " << event.stop + 1 << " of " << navigator_.num_stops() << ", waypoint "
         << tour_[event.stop];
  }
  if (!event.reason.empty()) text << ": " << event.reason;
  const std::string key = std::string("navigate.") + EventName(event.kind);
  shell.Publish(wire::kNote, wire::Encode(wire::Note{now, ++note_seq_, key, text.str()}));
  shell.log().Write(shell.Now(), process::Severity::kInfo, key, {{"what", text.str()}});
  shell.health().Count(key);
  if (event.kind == EventKind::kFinished) {
    shell.End(navigator_.num_unreachable() == 0 ? kExitOk : kExitFailed);
  } else if (record_ &&
             (event.kind == EventKind::kReached || event.kind == EventKind::kUnreachable)) {
    record_->AddStop(event, tour_[event.stop], navigator_.place(event.stop));
  }
}

void NavigateNode::ReportHealth(process::Shell& shell) {
  const char* poses = truth_ ? "GROUND_TRUTH" : "POSE with a map";
  if (!time_.At(shell.Now())) {
    shell.health().SetState(HealthState::kStarting, "no WHEEL message yet: check the base");
  } else if (!pose_) {
    shell.health().SetState(HealthState::kStarting, std::string("no ") + poses + " yet");
  } else if (navigator_.pose_state() != PoseState::kGood) {
    shell.health().SetState(HealthState::kDegraded, std::string("standing still, pose ") +
                                                        PoseStateName(navigator_.pose_state()));
  } else {
    shell.health().SetState(HealthState::kOk);
  }
}

void NavigateNode::Stop(process::Shell& shell) {
  if (const auto now = time_.At(shell.Now())) Command(*now, {}, shell);
  if (!record_) return;
  if (const auto closed = record_->Close(); !closed) {
    shell.log().Write(shell.Now(), process::Severity::kError, "navigate.record",
                      {{"what", closed.error().message}});
    shell.End(kExitFailed);
  }
}

}  // namespace gw::navigate

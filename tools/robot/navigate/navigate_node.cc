#include "tools/robot/navigate/navigate_node.h"

#include <sstream>
#include <utility>

#include "common/core/exit_code.h"
#include "common/wire/channels.h"
#include "common/wire/grid.h"
#include "tools/robot/explore/sight.h"
#include "tools/robot/navigate/explorer.h"
#include "tools/robot/navigate/navigator.h"

namespace gw::navigate {
namespace {

constexpr DurationUs kPeriod{1'000'000 / Driver::kRateHz};

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

Result<std::unique_ptr<NavigateNode>> NavigateNode::CreateTour(const RobotConfig& config,
                                                               const NavigateOptions& options) {
  if (options.map.empty() || options.waypoints.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "--map and --waypoints are required, or --explore in their place"};
  }
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
  const std::vector<int> tour =
      floorplan::StopsOfLaps(num_waypoints, std::move(visit), options.laps);
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
  std::vector<std::string> complaints = navigator->complaints();
  std::unique_ptr<NavigateNode> node(new NavigateNode(
      std::make_unique<Navigator>(*std::move(navigator)), MapFromWorld(start), options.truth));
  node->complaints_ = std::move(complaints);
  return node;
}

// What it drives on is GRID, which is in W, as POSE is.
Result<std::unique_ptr<NavigateNode>> NavigateNode::CreateExplorer(const RobotConfig& config,
                                                                   const NavigateOptions& options) {
  if (!options.map.empty() || !options.waypoints.empty() || !options.path.empty() ||
      !options.start.empty() || options.laps != 1 || options.truth) {
    return Error{ErrorCode::kInvalidArgument,
                 "--explore drives on POSE and GRID: no --map, --waypoints, --path, --laps, "
                 "--start or --truth with it"};
  }
  const auto camera = MakeCameraGeometry(config.calibration);
  if (!camera) return camera.error();
  const auto sight = explore::SightOf(*camera, config.grid);
  if (!sight) return sight.error();
  return std::unique_ptr<NavigateNode>(
      new NavigateNode(std::make_unique<Explorer>(config.navigate, *sight), SE3(), false));
}

Result<std::unique_ptr<process::Node>> NavigateNode::Create(const RobotConfig& config,
                                                            const NavigateOptions& options) {
  auto node = options.explore ? CreateExplorer(config, options) : CreateTour(config, options);
  if (!node) return node.error();
  if (!options.record.empty()) {
    auto record = RunRecord::Create(options.record);
    if (!record) return record.error();
    (*node)->record_.emplace(*std::move(record));
  }
  return std::unique_ptr<process::Node>(*std::move(node));
}

Result<Done> NavigateNode::Start(process::Shell& shell) {
  for (const std::string& complaint : complaints_) {
    shell.log().Write(shell.Now(), process::Severity::kWarning, "navigate.waypoint",
                      {{"what", complaint}});
  }
  auto ok =
      shell.Listen<WheelSample>(wire::kWheel, [this](const WheelSample& sample, Utime received) {
        time_.Observe(sample.utime, received);
        driver_->Sense(sample.contact);
      });
  if (!ok) return ok;
  ok =
      shell.Listen<ObstacleView>(wire::kObstacles, [this, &shell](const ObstacleView& view, Utime) {
        if (!driver_->See(view)) shell.health().Count("OBSTACLES.without_pose");
      });
  if (!ok) return ok;
  ok = shell.Listen<GridUpdate>(wire::kGrid, [this, &shell](const GridUpdate& update, Utime) {
    if (const auto now = time_.At(shell.Now())) driver_->Take(update, *now);
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
  driver_->Push(pose);
}

bool NavigateNode::Step(process::Shell& shell) {
  const Utime clock = shell.Now();
  if (updated_ && clock - *updated_ < kPeriod) return true;
  updated_ = clock;
  ReportHealth(shell);
  const auto now = time_.At(clock);
  if (!now) return true;  // no base yet
  const Driver::Output out = driver_->Update(*now);
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
    if (record_) record_->AddLeg(event.stop, driver_->leg());
    return;
  }
  std::string text = event.kind == EventKind::kFinished  ? driver_->Summary()
                     : event.stop < driver_->num_stops() ? driver_->NameOf(event.stop)
                                                         : "";
  if (!event.reason.empty()) text += (text.empty() ? "" : ": ") + event.reason;
  const std::string key = std::string("navigate.") + EventName(event.kind);
  shell.Publish(wire::kNote, wire::Encode(wire::Note{now, ++note_seq_, key, text}));
  shell.log().Write(shell.Now(), process::Severity::kInfo, key, {{"what", text}});
  shell.health().Count(key);
  if (event.kind == EventKind::kFinished) {
    if (record_) record_->SetSummary(text);
    shell.End(driver_->succeeded() ? kExitOk : kExitFailed);
  } else if (record_ &&
             (event.kind == EventKind::kReached || event.kind == EventKind::kUnreachable)) {
    record_->AddStop(event, driver_->waypoint(event.stop), driver_->place(event.stop));
  }
}

void NavigateNode::ReportHealth(process::Shell& shell) {
  const char* poses = truth_ ? "GROUND_TRUTH" : "POSE with a map";
  if (!time_.At(shell.Now())) {
    shell.health().SetState(HealthState::kStarting, "no WHEEL message yet: check the base");
  } else if (!pose_) {
    shell.health().SetState(HealthState::kStarting, std::string("no ") + poses + " yet");
  } else if (!driver_->waits_for().empty()) {
    shell.health().SetState(HealthState::kDegraded, "standing still, " + driver_->waits_for());
  } else if (driver_->pose_state() != PoseState::kGood) {
    shell.health().SetState(HealthState::kDegraded, std::string("standing still, pose ") +
                                                        PoseStateName(driver_->pose_state()));
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

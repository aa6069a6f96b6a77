// gw-closed-loop: drives of a simulated robot on the whole system, in lockstep.
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "common/cli/command.h"
#include "common/core/exit_code.h"
#include "grid/core/floor_image.h"
#include "grid/files/map_server.h"
#include "tools/lab/nav_eval/closed_loop.h"
#include "tools/robot/explore/coverage.h"
#include "tools/robot/floorplan/boxes_in_the_way.h"
#include "tools/robot/navigate/explorer.h"
#include "tools/robot/navigate/run_record.h"
#include "tools/sim/closed_loop/closed_loop.h"
#include "tools/sim/sim/scenario.h"

namespace gw::sim {
namespace {

constexpr int64_t kStartUs = 1'000'000'000'000'000;  // 2001-09-09
constexpr int64_t kPauseUs = 3'600'000'000;          // between two drives
constexpr double kBoxSide = 0.4, kBoxHeight = 0.5;   // m

// A drive that is cut off (SIGINT, SIGTERM) leaves what it has; no other begins.
volatile std::sig_atomic_t g_cut_off = 0;

void CutOff(int) {
  g_cut_off = 1;
}

struct Arguments {
  std::string scenario, map, waypoints, path, out;
  int seed = 0, boxes = 0, threads = 1;
  bool truth = false, jumps = false, no_obstacles = false, own_grid = false, explore = false;
  double rate_factor = 1;
};

// What both drives have in common.
struct Course {
  Scenario scenario;
  floorplan::FloorMap plan;
  RobotConfig config;
  ClosedLoopOptions options;
};

// Where the robot begins.
floorplan::Waypoint StartOf(const Simulation& sim) {
  const Eigen::Vector3d ahead = sim.T_GB().rotation() * Eigen::Vector3d::UnitX();
  return {sim.T_GB().translation().head<2>(), std::atan2(ahead.y(), ahead.x())};
}

std::vector<floorplan::Waypoint> Moved(const SE3& T, std::vector<floorplan::Waypoint> waypoints) {
  for (floorplan::Waypoint& w : waypoints) {
    const SE3 moved = T * navigate::MapFromWorld(w);
    const Eigen::Vector3d ahead = moved.rotation() * Eigen::Vector3d::UnitX();
    w = {moved.translation().head<2>(), std::atan2(ahead.y(), ahead.x())};
  }
  return waypoints;
}

Result<Course> LoadCourse(const Arguments& a) {
  auto scenario = LoadScenario(a.scenario);
  if (!scenario) return scenario.error();
  Course course{*std::move(scenario), {}, {}, {}};
  if (!a.map.empty()) course.scenario.map = a.map;
  if (a.seed > 0) course.scenario.seed = a.seed;
  if (!a.waypoints.empty()) {
    auto waypoints = floorplan::LoadWaypoints(a.waypoints);
    if (!waypoints) return waypoints.error();
    course.scenario.waypoints = *std::move(waypoints);
    course.scenario.visit.clear();
  }
  if (!a.path.empty()) {
    auto order =
        floorplan::LoadVisitOrder(a.path, static_cast<int>(course.scenario.waypoints.size()));
    if (!order) return order.error();
    course.scenario.visit = *std::move(order);
  }
  auto plan = floorplan::LoadFloorMap(course.scenario.map);
  if (!plan) return plan.error();
  course.plan = *std::move(plan);
  course.options.truth = a.truth;
  course.options.obstacles = !a.no_obstacles;
  return course;
}

// Boxes on the way of the tour.
void AddBoxes(int count, Course* course) {
  std::vector<floorplan::Waypoint> stops;
  for (const int index : floorplan::StopsOfLaps(static_cast<int>(course->scenario.waypoints.size()),
                                                course->scenario.visit, course->scenario.laps)) {
    stops.push_back(course->scenario.waypoints[index]);
  }
  const NavigateConfig& config = course->config.navigate;
  for (const Eigen::Vector2d& p :
       floorplan::PlacesInTheWay(course->plan, stops, config.robot_radius_m + config.clearance_m,
                                 kBoxSide, count, static_cast<uint64_t>(course->scenario.seed))) {
    // A little smaller than the cells that it covers, which are what the robot can touch.
    const double side = kBoxSide - 0.02;
    course->scenario.world.boxes.push_back({p, 0, side, side, kBoxHeight});
  }
  std::fprintf(stderr, "gw-closed-loop: %zu boxes in the way\n",
               course->scenario.world.boxes.size());
}

// How much of the floor that it could cover the robot has seen.
nlohmann::json Seen(const Course& course, const floorplan::Waypoint& start,
                    const navigate::Explorer& explorer, const SE3& T_MG) {
  const explore::Coverage seen = explore::CoverageOf(
      course.plan, start.position, course.config.navigate.robot_radius_m, explorer.map(), T_MG);
  return {{"summary", explorer.Summary()},
          {"frontiers", explorer.num_explored()},
          {"frontiers_left", explorer.num_left()},
          {"reachable_m2", seen.reachable_m2},
          {"seen_share", seen.seen_m2 / seen.reachable_m2}};
}

nlohmann::json Summary(const ClosedLoop& loop, const navigate::ClosedLoop& driven) {
  const DriveReport& r = loop.report();
  const PoseSteps& s = loop.steps();
  const double deg = 180 / std::numbers::pi;
  const auto speed = [](double way, double time) { return time > 0 ? way / time : 0.0; };
  nlohmann::json contacts_at = nlohmann::json::array();
  for (const Contact& contact : r.contacts) {
    contacts_at.push_back({{"seconds", contact.seconds},
                           {"x", contact.truth.position.x()},
                           {"y", contact.truth.position.y()},
                           {"pose_error_m", contact.pose_error_m}});
  }
  return {{"stops", r.stops},
          {"reached", r.reached},
          {"contacts", r.contacts.size()},
          {"contacts_at", contacts_at},
          {"blocked", r.blocked},
          {"held", r.held},
          {"finished", r.finished},
          {"seconds", r.seconds},
          {"way_m", r.way_m},
          {"speed_seeing_m_s", speed(r.seeing_way_m, r.seeing_s)},
          {"speed_blind_m_s", speed(r.blind_way_m, r.blind_s)},
          {"blind_s", r.blind_s},
          {"est_rmse_m", driven.est_rmse_m},
          {"nav_rmse_m", driven.nav_rmse_m},
          {"corrections", s.corrections()},
          {"step_composed_m", s.composed().m},
          {"step_composed_deg", s.composed().rad * deg},
          {"step_published_m", s.published().m},
          {"step_published_deg", s.published().rad * deg},
          {"outstanding_m", s.outstanding().m},
          {"not_covered", s.not_covered()},
          {"snaps", s.snaps()}};
}

void ShowEvent(double seconds, const navigate::Event& event) {
  if (event.kind == navigate::EventKind::kLeg) return;
  std::fprintf(stderr, "  %.1f s: stop %d %s %s at (%.2f, %.2f)\n", seconds, event.stop,
               navigate::EventName(event.kind), event.reason.c_str(), event.pose.position.x(),
               event.pose.position.y());
}

// The tour of the scenario on `map`.
Result<std::unique_ptr<navigate::Driver>> MakeTour(const Course& course,
                                                   const floorplan::FloorMap& map,
                                                   const SE3& T_MG) {
  const std::vector<int> tour =
      floorplan::StopsOfLaps(static_cast<int>(course.scenario.waypoints.size()),
                             course.scenario.visit, course.scenario.laps);
  auto navigator = navigate::Navigator::Create(course.config.navigate, map,
                                               Moved(T_MG, course.scenario.waypoints), tour);
  if (!navigator) return navigator.error();
  for (const std::string& complaint : navigator->complaints()) {
    std::fprintf(stderr, "gw-closed-loop: %s\n", complaint.c_str());
  }
  return std::unique_ptr<navigate::Driver>(
      std::make_unique<navigate::Navigator>(*std::move(navigator)));
}

Result<std::unique_ptr<navigate::Driver>> MakeExplorer(const RobotConfig& config) {
  const auto camera = MakeCameraGeometry(config.calibration);
  if (!camera) return camera.error();
  const auto sight = explore::SightOf(*camera, config.grid);
  if (!sight) return sight.error();
  return std::unique_ptr<navigate::Driver>(
      std::make_unique<navigate::Explorer>(config.navigate, *sight));
}

// One drive; its record goes to `folder`. T_MG: the map of the driver.
Result<std::unique_ptr<ClosedLoop>> Drive(const Course& course, std::unique_ptr<Simulation> sim,
                                          std::unique_ptr<navigate::Driver> driver, const SE3& T_MG,
                                          tools::MapStart start, const std::string& folder) {
  const floorplan::Waypoint begin = StartOf(*sim);
  const SE3 T_MW = T_MG * navigate::MapFromWorld(begin);
  auto created = ClosedLoop::Create(std::move(sim), course.config, std::move(start),
                                    std::move(driver), T_MG, T_MW, course.options);
  if (!created) return created.error();
  ClosedLoop& loop = **created;
  auto record = navigate::RunRecord::Create(folder);
  if (!record) return record.error();
  eval::Trajectory truth;
  Utime recorded;
  loop.on_pose = [&](const navigate::RobotPose& pose) {
    if (pose.utime - recorded < Milliseconds(50)) return;
    recorded = pose.utime;
    record->AddPose(pose);
  };
  loop.on_truth = [&](const navigate::RobotPose& pose) {
    truth.push_back({pose.utime, navigate::MapFromWorld({pose.position, pose.yaw})});
  };
  loop.on_event = [&](const navigate::Event& event) {
    ShowEvent(loop.seconds(), event);
    if (event.kind == navigate::EventKind::kLeg) {
      record->AddLeg(event.stop, loop.driver().leg());
    } else if (event.kind == navigate::EventKind::kReached ||
               event.kind == navigate::EventKind::kUnreachable) {
      record->AddStop(event, loop.driver().waypoint(event.stop), loop.driver().place(event.stop));
    }
  };
  loop.Run([](double seconds) {
    if (std::fmod(seconds, 20) < 0.5) std::fprintf(stderr, "  %.0f s\n", seconds);
    return g_cut_off == 0;
  });
  if (const auto closed = record->Close(); !closed) return closed.error();
  const auto driven = navigate::ReadTourRecord(folder);
  if (!driven) return driven.error();
  const auto measured = navigate::Evaluate(*driven, truth);
  if (!measured) return measured.error();
  nlohmann::json summary = Summary(loop, *measured);
  if (const auto* explorer = dynamic_cast<const navigate::Explorer*>(&loop.driver())) {
    summary.update(Seen(course, begin, *explorer, T_MG));
    std::fprintf(stderr, "gw-closed-loop: %s\n", explorer->Summary().c_str());
  }
  const std::string text = summary.dump(1);
  std::ofstream(folder + "/drive.json") << text << "\n";
  std::printf("%s: %s\n", folder.c_str(), text.c_str());
  loop.on_pose = loop.on_truth = nullptr;
  loop.on_event = nullptr;
  return created;
}

Result<std::unique_ptr<Simulation>> MakeSimulation(const Course& course, const Arguments& a,
                                                   Utime start) {
  return Simulation::Create(course.scenario, course.plan, sim::Drive::kExternal, start, a.threads);
}

Result<Done> Run(const Arguments& a) {
  auto loaded = LoadCourse(a);
  if (!loaded) return loaded.error();
  Course& course = *loaded;
  if (!a.own_grid && a.boxes > 0) AddBoxes(a.boxes, &course);
  auto sim = MakeSimulation(course, a, {kStartUs});
  if (!sim) return sim.error();
  course.config = (*sim)->robot_config();
  if (!a.jumps) {
    course.options.rates = {
        a.rate_factor * course.config.dr_ekf.pose_correction_m_s,
        a.rate_factor * course.config.dr_ekf.pose_correction_deg_s * std::numbers::pi / 180};
  }
  const SE3 T_WG = navigate::MapFromWorld(StartOf(**sim)).inverse();
  auto driver = a.explore ? MakeExplorer(course.config) : MakeTour(course, course.plan, SE3());
  if (!driver) return driver.error();
  auto first = Drive(course, *std::move(sim), *std::move(driver), a.explore ? T_WG : SE3(), {},
                     a.out + "/first");
  if (!first) return first.error();
  if (!a.own_grid && !a.explore) return Done{};

  grid::GridMap& grid = (*first)->grid();
  const std::string folder = a.out + "/grid";
  const auto written =
      grid::WriteMapServer(folder, grid::MakeFloorImage(grid.tiles(), grid.cell_m()));
  if (!written) return written.error();
  const auto own = floorplan::LoadFloorMap(folder + "/map.yaml");
  if (!own) return own.error();
  if (!a.own_grid || g_cut_off != 0) return Done{};
  const backend::Map map = (*first)->slam().mapper().map();
  first->reset();
  const auto again = [&](const std::string& name) -> Result<Done> {
    auto next = MakeSimulation(course, a, {kStartUs + kPauseUs});
    if (!next) return next.error();
    auto tour = MakeTour(course, *own, T_WG);
    if (!tour) return tour.error();
    const auto drive = Drive(course, *std::move(next), *std::move(tour), T_WG,
                             {map, {}, backend::MapUse::kGrow}, a.out + "/" + name);
    if (!drive) return drive.error();
    return Done{};
  };
  auto done = again("own_grid");
  if (!done || a.boxes == 0 || g_cut_off != 0) return done;
  AddBoxes(a.boxes, &course);
  return again("boxes");
}

}  // namespace
}  // namespace gw::sim

int main(int argc, char** argv) {
  gw::sim::Arguments a;
  gw::cli::Command app(
      "Drives of a simulated robot on the whole system, in lockstep and without a bus: the same "
      "scenario gives the same drive, however busy the machine is. Prints and writes drive.json, "
      "also of a drive that SIGINT or SIGTERM cuts off.\n"
      "Exit: 0 ok (also when stops were not reached), 1 failed, 2 usage, 78 bad scenario.");
  app.AddOption("--scenario", a.scenario, "what happens (YAML, config/scenarios)")->Required();
  app.AddOption("--out", a.out, "folder for the records")->Required();
  app.AddOption("--map", a.map, "map.yaml of the building, in place of the scenario's");
  app.AddOption("--waypoints", a.waypoints, "lines `index x y theta`");
  app.AddOption("--path", a.path, "indices of waypoints to visit, one a line");
  app.AddOption("--seed", a.seed, "in place of the scenario's")->Positive();
  app.AddOption("--threads", a.threads, "that render")->InRange(1, 64);
  app.AddOption("--boxes", a.boxes,
                "so many boxes in the way that the map does not have (with --own-grid: in a "
                "third drive, like the second)")
      ->InRange(0, 50);
  app.AddFlag("--explore", a.explore,
              "explore the building in the first drive, in place of the tour; leaves the floor "
              "map in OUT/grid");
  app.AddFlag("--own-grid", a.own_grid,
              "then a second drive, on the floor map and in the map that the first one made");
  app.AddFlag("--truth", a.truth, "drive on the true pose");
  app.AddFlag("--jumps", a.jumps, "make corrections of POSE at once");
  app.AddOption("--rate-factor", a.rate_factor, "on the rates of corrections of POSE")->Positive();
  app.AddFlag("--no-obstacles", a.no_obstacles, "do not show obstacles to the navigator");
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  std::signal(SIGINT, gw::sim::CutOff);
  std::signal(SIGTERM, gw::sim::CutOff);
  const auto done = gw::sim::Run(a);
  if (done) return gw::kExitOk;
  std::fprintf(stderr, "gw-closed-loop: %s\n", done.error().message.c_str());
  return gw::ExitCodeFor(done.error());
}

// gw-sim: a robot in a world.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>

#include "common/cli/command.h"
#include "common/config/writer.h"
#include "common/core/exit_code.h"
#include "common/process/bus.h"
#include "common/process/clock.h"
#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "grid/files/map_server.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/robot/floorplan/planner.h"
#include "tools/sim/sim/scenario.h"
#include "tools/sim/sim/simulation.h"
#include "tools/sim/sim/standing_plan.h"

namespace gw::sim {
namespace {

constexpr int64_t kStartUs = 1'000'000'000'000'000;  // of runs that are not live: 2001-09-09

volatile std::sig_atomic_t g_stop = 0;  // what a signal handler may touch
void OnSignal(int) {
  g_stop = 1;
}

struct Arguments {
  std::string map, waypoints, path, scenario, log, config_out, plan_out, lcm_url, trajectory,
      odometry;
  std::optional<int> seed;
  std::optional<double> duration;
  std::optional<int64_t> start_utime;
  bool realtime = false, fast = false;
  std::string drive = "path";
  int threads = 2;
};

Result<Scenario> LoadAll(const Arguments& a) {
  auto loaded = LoadScenario(a.scenario);
  if (!loaded) return loaded.error();
  Scenario scenario = *std::move(loaded);
  if (!a.map.empty()) scenario.map = a.map;
  if (scenario.map.empty() && a.trajectory.empty()) {
    return Error{ErrorCode::kBadConfig, a.scenario + ":1: names no map, and --map is not given"};
  }
  if (!a.waypoints.empty()) {
    auto waypoints = floorplan::LoadWaypoints(a.waypoints);
    if (!waypoints) return waypoints.error();
    scenario.waypoints = *std::move(waypoints);
    if (a.path.empty()) scenario.visit.clear();
  }
  if (!a.path.empty()) {
    auto order = floorplan::LoadVisitOrder(a.path, static_cast<int>(scenario.waypoints.size()));
    if (!order) return order.error();
    scenario.visit = *std::move(order);
  }
  for (const int index : scenario.visit) {
    if (index >= static_cast<int>(scenario.waypoints.size())) {
      return Error{ErrorCode::kBadConfig,
                   a.scenario + ":1: visit: there is no waypoint " + std::to_string(index)};
    }
  }
  if (a.seed) scenario.seed = *a.seed;
  if (a.duration) scenario.max_duration_s = *a.duration;
  return scenario;
}

Result<Done> WriteConfig(const RobotConfig& config, const std::string& path) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << WriteRobotConfig(config, ConfigText::kShort);
  out.close();
  if (!out) return Error{ErrorCode::kIo, path + ": cannot write the robot configuration"};
  return Done{};
}

// What stands between the heights that matter to the robot, as a map of map_server.
Result<Done> WritePlan(const Simulation& sim, const floorplan::FloorMap& map,
                       const std::string& directory) {
  const GridConfig& grid = sim.robot_config().grid;
  return grid::WriteMapServer(
      directory, StandingPlan(sim.world(), map, sim.T_GB().translation().head<2>(), grid.step_m,
                              grid.robot_height_m, grid.cell_m));
}

class Progress {
 public:
  void Show(const Simulation& sim) {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::seconds(10)) return;
    last_ = now;
    std::fprintf(stderr, "gw-sim: %.1f s simulated in %.1f s, %lld images\n", sim.seconds(),
                 Elapsed(), static_cast<long long>(sim.images()));
  }
  double Elapsed() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_ = begin_;
};

// Keeps the simulation from running faster than the clock. What it falls behind it stays behind:
// catching up would be a world that runs fast for a while, for those who drive in it.
class Pace {
 public:
  void WaitUntil(double seconds) {
    const auto due = begin_ + std::chrono::duration_cast<Clock::duration>(
                                  std::chrono::duration<double>(seconds));
    const auto late = Clock::now() - due;
    if (late > kSlack) begin_ += late - kSlack;
    std::this_thread::sleep_until(due);
  }
  double lost_s() const { return std::chrono::duration<double>(begin_ - created_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr auto kSlack = std::chrono::milliseconds(100);  // rendering one image
  const Clock::time_point created_ = Clock::now();
  Clock::time_point begin_ = created_;
};

constexpr double kCorridorHalfWidth = 1.6;  // m, around a recorded way without a map

Result<std::unique_ptr<Simulation>> CreateSimulation(const Arguments& a, const Scenario& scenario,
                                                     Drive drive, Utime start) {
  if (a.trajectory.empty()) {
    const auto map = floorplan::LoadFloorMap(scenario.map);
    if (!map) return map.error();
    return Simulation::Create(scenario, *map, drive, start, a.threads);
  }
  auto motion = RecordedMotion::Load(a.trajectory, a.odometry);
  if (!motion) return motion.error();
  // The scenario's own map has nothing to do with the recording.
  const auto map = a.map.empty()
                       ? Result<floorplan::FloorMap>(motion->CorridorAround(kCorridorHalfWidth))
                       : floorplan::LoadFloorMap(a.map);
  if (!map) return map.error();
  return Simulation::Create(scenario, *map, *std::move(motion), start, a.threads);
}

Result<Done> Run(const Arguments& a) {
  const auto scenario = LoadAll(a);
  if (!scenario) return scenario.error();
  const process::Clock clock;
  const Utime start = a.start_utime ? Utime{*a.start_utime}
                      : a.realtime  ? clock.Now()
                                    : Utime{kStartUs};
  const Drive drive = a.drive == "external" ? Drive::kExternal : Drive::kPath;
  auto created = CreateSimulation(a, *scenario, drive, start);
  if (!created) return created.error();
  Simulation& sim = **created;
  if (!a.config_out.empty()) {
    const auto written = WriteConfig(sim.robot_config(), a.config_out);
    if (!written) return written.error();
  }
  if (!a.plan_out.empty()) {
    const auto map = floorplan::LoadFloorMap(scenario->map);
    if (!map) return map.error();
    const auto written = WritePlan(sim, *map, a.plan_out);
    if (!written) return written.error();
  }
  // A log that is not complete never has the log's name.
  const std::string part = a.log + ".part";
  std::optional<process::EventLogWriter> log;
  if (!a.log.empty()) {
    auto writer = process::EventLogWriter::Create(part);
    if (!writer) return writer.error();
    log.emplace(*std::move(writer));
  }
  std::unique_ptr<process::LiveBus> bus;
  if (a.realtime) {
    auto live = process::LiveBus::Create(a.lcm_url);
    if (!live) return live.error();
    bus = *std::move(live);
    if (!bus->warning().empty())
      std::fprintf(stderr, "gw-sim: warning: %s\n", bus->warning().c_str());
    if (drive == Drive::kExternal) {
      const auto subscribed =
          bus->Subscribe(wire::kBaseCommand, [&sim](std::span<const uint8_t> message, Utime) {
            const auto command = wire::Decode<BaseCommand>(message);
            if (command) sim.Command(*command);
          });
      if (!subscribed) return subscribed.error();
    }
  }
  const auto deliver = [&](bool all) -> Result<Done> {
    for (const Outgoing& out : sim.Take(all)) {
      if (log) {
        const auto done = log->Append(out.arrival, out.channel, out.message);
        if (!done) return done.error();
      }
      if (bus) {
        const auto done = bus->Publish(std::string(out.channel), out.message);
        if (!done) return done.error();
      }
    }
    return Done{};
  };
  Progress progress;
  Pace pace;
  while (g_stop == 0 && sim.Step()) {
    const auto delivered = deliver(false);
    if (!delivered) return delivered.error();
    progress.Show(sim);
    if (!bus) continue;
    pace.WaitUntil(sim.seconds());
    if (drive == Drive::kExternal) {
      const auto pumped = bus->Pump(0);
      if (!pumped) return pumped.error();
    }
  }
  const auto delivered = deliver(true);
  if (!delivered) return delivered.error();
  if (log && g_stop != 0 && drive == Drive::kPath) {
    return Error{ErrorCode::kIo, "interrupted: " + part + " ends before the way does"};
  }
  if (log) {
    const auto closed = log->Close();
    if (!closed) return closed.error();
    std::error_code error;
    std::filesystem::rename(part, a.log, error);
    if (error) return Error{ErrorCode::kIo, a.log + ": " + error.message()};
  }
  if (sim.commands_refused() > 0) {
    std::fprintf(stderr, "gw-sim: warning: %lld commands were older than 0.3 s and refused\n",
                 static_cast<long long>(sim.commands_refused()));
  }
  const double elapsed = progress.Elapsed();
  const std::string stops = drive == Drive::kPath
                                ? ", " + std::to_string(sim.stops_reached()) + " of " +
                                      std::to_string(sim.num_stops()) + " stops"
                                : "";
  std::fprintf(stderr, "gw-sim: done: %.1f s, %lld images (%.1f a second)%s%s\n", sim.seconds(),
               static_cast<long long>(sim.images()), static_cast<double>(sim.images()) / elapsed,
               stops.c_str(), sim.bumper_hit() ? ", touched a wall" : ", touched no wall");
  if (bus && pace.lost_s() > 0.1) {
    std::fprintf(
        stderr,
        "gw-sim: warning: %.1f s slower than real time: the machine is busy, or the camera "
        "too much for it\n",
        pace.lost_s());
  }
  return Done{};
}

int Main(int argc, char** argv) {
  Arguments a;
  cli::Command app(
      "A robot in a world: renders its camera, drives it and emits its sensors over LCM or into a "
      "log.\nExit: 0 ok, 1 failed, 2 usage, 78 bad scenario.");
  app.AddOption("--scenario", a.scenario, "what happens (YAML, config/scenarios)")->Required();
  app.AddOption("--map", a.map, "map.yaml of map_server, in place of the scenario's");
  app.AddOption("--waypoints", a.waypoints, "lines `index x y theta`, in place of the scenario's");
  app.AddOption("--path", a.path, "indices of waypoints to visit, one a line");
  app.AddOption("--seed", a.seed, "in place of the scenario's");
  app.AddOption("--duration", a.duration, "end after this many seconds")->Positive();
  app.AddOption("--log", a.log, "LCM log to write");
  app.AddOption("--config-out", a.config_out, "robot configuration (YAML) to write");
  auto* plan_out = app.AddOption("--plan-out", a.plan_out,
                                 "folder for map.yaml and map.pgm of what was built: walls and "
                                 "furniture between the robot's floor and its top");
  auto* realtime =
      app.AddFlag("--realtime", a.realtime, "publish on LCM, at the pace of the clock");
  app.AddFlag("--fast", a.fast, "as fast as possible (default)")->Excludes(realtime);
  app.AddOption("--lcm-url", a.lcm_url, "bus for --realtime");
  app.AddOption("--drive", a.drive, "path: follow the waypoints; external: obey BASE_COMMAND")
      ->OneOf({"path", "external"});
  auto* trajectory = app.AddOption("--trajectory", a.trajectory,
                                   "recorded poses `t x y z qx qy qz qw` to render along; walls "
                                   "are put around them unless --map is given");
  auto* odometry =
      app.AddOption("--odometry", a.odometry, "the recorded robot's odometry, passed through");
  trajectory->Needs(odometry)->Excludes(plan_out);
  odometry->Needs(trajectory);
  app.AddOption("--start-utime", a.start_utime,
                "stamp of the first instant, us (default: fixed; with --realtime, now)");
  app.AddOption("--threads", a.threads, "that render; the output does not depend on it")
      ->InRange(1, 64);
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  if (a.drive == "external" && !a.realtime) {
    std::fprintf(stderr, "gw-sim: --drive external needs --realtime: commands come over LCM\n");
    return kExitUsage;
  }
  if (a.lcm_url.empty()) a.lcm_url = ProcessConfig{}.lcm_url;
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
  const auto done = Run(a);
  if (!done) {
    std::fprintf(stderr, "gw-sim: %s\n", done.error().message.c_str());
    return ExitCodeFor(done.error());
  }
  return kExitOk;
}

}  // namespace
}  // namespace gw::sim

int main(int argc, char** argv) {
  return gw::sim::Main(argc, argv);
}

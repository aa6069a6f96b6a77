// One simulated run: moves the robot through its world millisecond by millisecond and gives out
// what its sensors measure, as LCM messages in order of arrival.
//
// Everything follows from the scenario, the map and the seed; nothing depends on how fast it runs
// or on the number of threads.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <tuple>
#include <vector>

#include "common/config/robot_config.h"
#include "common/core/result.h"
#include "common/wire/wire.h"
#include "drivers/kobuki/core/command_shaper.h"
#include "drivers/kobuki/core/safety_guard.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/robot/floorplan/waypoints.h"
#include "tools/sim/sim/base.h"
#include "tools/sim/sim/camera_sensor.h"
#include "tools/sim/sim/floor_profile.h"
#include "tools/sim/sim/odometry_resampler.h"
#include "tools/sim/sim/path_follower.h"
#include "tools/sim/sim/recorded_motion.h"
#include "tools/sim/sim/renderer.h"
#include "tools/sim/sim/scenario.h"
#include "tools/sim/sim/sensors.h"
#include "tools/sim/sim/world.h"

namespace gw::sim {

struct Outgoing {
  Utime arrival;
  std::string_view channel;
  wire::Bytes message;
};

enum class Drive {
  kPath,      // follows the waypoints on ground truth
  kExternal,  // obeys Command
};

class Simulation {
 public:
  // start: stamp of the first instant. threads: that render. Error kBadData: a waypoint or the
  // target of a kidnap is in a wall or cannot be reached.
  static Result<std::unique_ptr<Simulation>> Create(const Scenario& scenario,
                                                    const floorplan::FloorMap& map, Drive drive,
                                                    Utime start, int threads);

  // Along a recorded robot's way, with its odometry: no waypoints, no commands, and events that
  // move the robot have no effect.
  static Result<std::unique_ptr<Simulation>> Create(const Scenario& scenario,
                                                    const floorplan::FloorMap& map,
                                                    RecordedMotion motion, Utime start,
                                                    int threads);

  // Moves on by one millisecond. False, without moving, when the run is over.
  bool Step();
  // What has arrived by now; with `all`, also what is still under way.
  std::vector<Outgoing> Take(bool all = false);
  // From BASE_COMMAND; for Drive::kExternal. Treated as gw-kobuki treats it with its default
  // configuration: refused when older than 0.3 s, forgotten after as long, ramped, and no forward
  // speed after the bumper was hit until something else was commanded.
  void Command(const BaseCommand& command);

  Utime now() const { return now_; }
  double seconds() const { return (now_ - start_).seconds(); }
  int64_t images() const { return frame_; }
  int stops_reached() const;
  int num_stops() const { return static_cast<int>(stops_.size()); }
  bool bumper_hit() const { return bumper_hit_; }  // at any time so far
  int64_t commands_refused() const { return commands_refused_; }
  const SE3& T_GB() const { return T_GB_; }
  const World& world() const { return *world_; }
  // As its maker sees it: where the camera should be.
  const RobotConfig& robot_config() const { return robot_config_; }

 private:
  Simulation(const Scenario& scenario, Drive drive, Utime start, int threads);

  Result<std::vector<floorplan::Leg>> PlanStops(const floorplan::FloorMap& map, double clearance);
  void Build(const floorplan::FloorMap& map, const floorplan::Waypoint& first,
             const std::vector<Eigen::Vector2d>& keep_free);
  void SendRecordedOdometry();
  Disturbance DisturbanceNow() const;
  void FollowPath();
  void ObeyCommand();
  Result<Done> Replan(const floorplan::Waypoint& from);
  void BeginEvents();
  void TakeImage(Utime at, const SE3& T_GB, const CameraMotion& motion);
  void Measure(const SE3& T_GB_before, Utime before);
  void Note(const std::string& key, const std::string& text);
  void Truth(Utime at, const SE3& T_GB);
  void Send(Utime arrival, int rank, std::string_view channel, wire::Bytes message);

  Scenario scenario_;
  Drive drive_;
  Utime start_, now_;
  RobotConfig robot_config_;
  SE3 T_BC_, T_BI_;  // as mounted
  WorkerPool pool_;
  std::vector<floorplan::Waypoint> stops_;
  std::unique_ptr<World> world_;
  floorplan::FloorMap contacts_;  // what the robot touches of world_
  std::vector<float> distance_;   // to that
  std::unique_ptr<Base> base_;
  std::unique_ptr<PathFollower> follower_;
  int legs_before_replan_ = 0;
  kobuki::CommandShaper shaper_;
  kobuki::SafetyGuard guard_;
  std::optional<RecordedMotion> recorded_;
  size_t next_odometry_ = 1;
  FloorProfile floor_;
  std::unique_ptr<Renderer> renderer_;
  CameraSensor left_eye_, right_eye_;
  AutoExposure auto_exposure_;
  ImuSensor imu_;
  WheelSensor wheels_;
  OdometryResampler odometry_;

  SE3 T_GB_;
  Eigen::Vector3d p_GI_ = Eigen::Vector3d::Zero();
  double finished_at_s_ = -1;
  int64_t commands_refused_ = 0;
  bool bumper_hit_ = false;
  size_t next_event_ = 0;  // in order of time
  int64_t frame_ = 0, imu_count_ = 0, wheel_count_ = 0, truth_seq_ = 0, note_seq_ = 0;
  Utime last_truth_;
  RenderedImage left_scene_, right_scene_;
  std::vector<uint8_t> left_image_, right_image_;
  std::vector<uint16_t> depth_image_;
  // Under way, by arrival; ties by rank of the channel, then in order of making.
  std::map<std::tuple<int64_t, int, int64_t>, Outgoing> pending_;
  int64_t made_ = 0;
};

}  // namespace gw::sim

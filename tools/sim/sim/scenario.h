// What happens in one simulated run, as YAML: where, along which way, in what kind of building,
// what goes wrong and when. Every key is explained in config/scenarios/README.md.
#pragma once

#include <string>
#include <vector>

#include "common/core/result.h"
#include "tools/robot/floorplan/waypoints.h"
#include "tools/sim/sim/base.h"
#include "tools/sim/sim/camera_sensor.h"
#include "tools/sim/sim/depth_sensor.h"
#include "tools/sim/sim/mounting.h"
#include "tools/sim/sim/odometry_resampler.h"
#include "tools/sim/sim/path_follower.h"
#include "tools/sim/sim/world.h"

namespace gw::sim {

enum class EventKind {
  kLightsOff,    // all lamps; level: what remains, 0 to 1
  kLensCovered,  // no light reaches the camera
  kGlare,        // a low sun; strength, azimuth_deg (world), shines along it from above
  kSlip,         // wheels turn, the robot moves traction times as far
  kPush,         // moved by dx, dy (m, body) and turned by dyaw_deg while the wheels do not notice
  kKidnap,       // at once elsewhere: to [x, y, theta]
  kDropFrames,   // share of the images is lost
  kLateFrames,   // images arrive delay_ms later
};

struct Event {
  EventKind kind = EventKind::kLightsOff;
  double at_s = 0;
  double for_s = 0;  // 0 only for kidnap
  double level = 0;
  double strength = 4, azimuth_deg = 0;
  double traction = 0.4;
  double dx = 0, dy = 0, dyaw_deg = 0;
  floorplan::Waypoint to;
  double share = 0.5;
  double delay_ms = 100;

  bool ActiveAt(double t) const { return t >= at_s && t < at_s + for_s; }
};
const char* EventName(EventKind kind);

enum class CameraMode { kStereo, kRgbd };

struct ImuConfig {
  double rate_hz = 200;
  double gyro_noise = 2.4e-4;  // rad/s/sqrt(Hz); BMI055: 0.014 deg/s/sqrt(Hz)
  double gyro_walk = 3e-5;     // rad/s^2/sqrt(Hz)
  double gyro_bias = 0.004;    // rad/s, sigma of the bias at the start
  // Relative, each axis; a size as in BaseConfig. BMI055: 1 % typical, not calibrated in a D435i.
  double gyro_scale_error = 0.008;
  double accel_noise = 1.5e-3;  // m/s^2/sqrt(Hz); BMI055: 150 ug/sqrt(Hz)
  double accel_walk = 3e-4;     // m/s^3/sqrt(Hz)
  double accel_bias = 0.05;     // m/s^2
  // A driving robot shakes: RMS at 0.5 m/s, in proportion to the speed. Measured as differences of
  // neighbouring samples on a real robot with an IMU at 100 Hz: 0.006 to 0.014 rad/s at 0.7 m/s.
  double shake_rad_s = 0.008;
  double shake_m_s2 = 0.1;
};

// Ways of recorded robots (RecordedMotion); see hard_way.h.
struct RecordedConfig {
  double length_m = 1e9;  // the run ends after so much of the way
  double every_m = 40;    // length of a part, each of which has
  double dark_s = 0;      // ... one span with the lights out
  double bare_m = 0;      // ... and one between bare walls
};

struct Scenario {
  std::string name;
  std::string map;  // path of map.yaml
  std::vector<floorplan::Waypoint> waypoints;
  std::vector<int> visit;  // indices of waypoints; empty: all in order
  int laps = 1;            // how often the order is driven; it must end where it begins if above 1
  int seed = 1;
  double max_duration_s = 3600;  // the run ends here, or at the end of the way
  double rest_s = 1.5;           // standing still at the start
  CameraMode camera = CameraMode::kStereo;
  Pinhole pinhole;
  double camera_rate_hz = 30;
  // Where the robot's configuration says that the camera is: of its left eye in the body frame, m,
  // and how far its axis looks up, rad. As in config/robots/turtlebot2_d435i.yaml.
  Eigen::Vector3d camera_position = {0.1, 0.0175, 0.25};
  double camera_up_rad = 0;
  ImagerConfig imager;
  DepthConfig depth;
  ImuConfig imu;
  BaseConfig base;
  OdometryConfig odometry;
  MountingConfig mounting;
  double floor_roughness = 1;
  double light = 1;  // of all lamps, of what a well lit office has
  FollowerConfig drive;
  WorldConfig world;
  RecordedConfig recorded;
  std::vector<Event> events;
};

// Relative paths in the file are relative to it. Error: kNotFound, or kBadConfig with one line for
// each mistake, FILE:LINE: KEY: RULE.
Result<Scenario> LoadScenario(const std::string& path);
Result<Scenario> ParseScenario(const std::string& text, const std::string& name);

}  // namespace gw::sim

// The whole configuration: one YAML per robot, one struct here. Every process loads all of it and
// uses its part.
#pragma once

#include <string>

#include "common/camera/calibration.h"
#include "common/config/backend_config.h"
#include "common/config/camera_config.h"
#include "common/config/dr_ekf_config.h"
#include "common/config/frontend_config.h"
#include "common/config/grid_config.h"
#include "common/config/kobuki_config.h"
#include "common/config/navigate_config.h"
#include "common/core/fields.h"

namespace gw {

struct RobotSection {
  std::string name;

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Field("name", name,
            {.required = true, .text = "of the robot or recording; appears in reports"});
  }
};

struct DriversConfig {
  CameraConfig camera;
  KobukiConfig kobuki;

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Section("camera", camera, {.text = "camera and its IMU (gw-camera)"});
    v.Section("kobuki", kobuki, {.text = "Kobuki base (gw-kobuki)"});
  }
};

struct ProcessConfig {
  std::string lcm_url = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304";
  int slam_backend_latency_ms = 150;

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Field("lcm_url", lcm_url, {.text = "bus of all processes; --lcm-url overrides"});
    v.Field("slam_backend_latency_ms", slam_backend_latency_ms,
            {.min = 0,
             .max = 10000,
             .unit = "ms",
             .text = "gw-slam: time from a keyframe to the map update that it causes"});
  }
};

struct RobotConfig {
  RobotSection robot;
  Calibration calibration;
  DriversConfig drivers;
  FrontendConfig frontend;
  BackendConfig backend;
  DrEkfConfig dr_ekf;
  GridConfig grid;
  NavigateConfig navigate;
  ProcessConfig process;

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Section("robot", robot, {.required = true, .text = "who this is"});
    v.Section(
        "calibration", calibration,
        {.required = true, .text = "sensors: what they are, where they are, how noisy they are"});
    v.Section("drivers", drivers, {.text = "devices"});
    v.Section("frontend", frontend, {.text = "tracking"});
    v.Section("backend", backend, {.text = "mapping"});
    v.Section("dr_ekf", dr_ekf, {.text = "dead reckoning"});
    v.Section("grid", grid, {.text = "floor map and obstacles (gw-grid)"});
    v.Section("navigate", navigate, {.text = "driving to waypoints (gw-navigate)"});
    v.Section("process", process, {.text = "bus and scheduling"});
  }
};

}  // namespace gw

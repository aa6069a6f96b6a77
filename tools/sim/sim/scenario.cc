#include "tools/sim/sim/scenario.h"

#include <filesystem>
#include <numbers>
#include <sstream>

#include "tools/data/files/strict_yaml.h"
#include "tools/data/files/text_file.h"

namespace gw::sim {
namespace {

using tools::ReadNumbers;
using tools::StrictMap;
using tools::YamlReport;

const std::vector<std::pair<const char*, EventKind>> kEventKinds = {
    {"lights_off", EventKind::kLightsOff},
    {"lens_covered", EventKind::kLensCovered},
    {"glare", EventKind::kGlare},
    {"slip", EventKind::kSlip},
    {"push", EventKind::kPush},
    {"kidnap", EventKind::kKidnap},
    {"drop_frames", EventKind::kDropFrames},
    {"late_frames", EventKind::kLateFrames}};

constexpr double kFar = 1e5;  // m

void ReadWaypoints(StrictMap* map, std::vector<floorplan::Waypoint>* out) {
  const YAML::Node list = map->Take("waypoints");
  if (!list.IsDefined()) return;
  if (!list.IsSequence()) {
    map->report()->Add(list, "waypoints: must be a list of [x, y, theta]");
    return;
  }
  for (const auto& node : list) {
    std::vector<double> v;
    if (ReadNumbers(node, "waypoints[" + std::to_string(out->size()) + "]", 3, map->report(), &v)) {
      out->push_back({{v[0], v[1]}, v[2]});
    }
  }
}

void ReadVisit(StrictMap* map, std::vector<int>* out) {
  const YAML::Node list = map->Take("visit");
  if (!list.IsDefined()) return;
  for (const auto& node : list) {
    int index = -1;
    std::istringstream(node.IsScalar() ? node.Scalar() : "") >> index;
    if (index < 0) {
      map->report()->Add(node, "visit: must be a list of waypoint indices");
      return;
    }
    out->push_back(index);
  }
}

void ReadRegions(StrictMap* map, const char* key, std::vector<Region>* out) {
  const YAML::Node list = map->Take(key);
  if (!list.IsDefined()) return;
  if (!list.IsSequence()) {
    map->report()->Add(list, map->PathOf(key) + ": must be a list of [x_min, y_min, x_max, y_max]");
    return;
  }
  for (const auto& node : list) {
    std::vector<double> v;
    const std::string path = map->PathOf(key) + "[" + std::to_string(out->size()) + "]";
    if (!ReadNumbers(node, path, 4, map->report(), &v)) continue;
    if (v[0] >= v[2] || v[1] >= v[3]) {
      map->report()->Add(node, path + ": the minimum must lie below the maximum");
      continue;
    }
    out->push_back({v[0], v[1], v[2], v[3]});
  }
}

void ReadBoxes(StrictMap* map, const char* key, std::vector<LooseBox>* out) {
  const YAML::Node list = map->Take(key);
  if (!list.IsDefined()) return;
  if (!list.IsSequence()) {
    map->report()->Add(list,
                       map->PathOf(key) + ": must be a list of [x, y, yaw, depth, width, height]");
    return;
  }
  for (const auto& node : list) {
    std::vector<double> v;
    const std::string path = map->PathOf(key) + "[" + std::to_string(out->size()) + "]";
    if (!ReadNumbers(node, path, 6, map->report(), &v)) continue;
    if (v[3] <= 0 || v[4] <= 0 || v[5] <= 0) {
      map->report()->Add(node, path + ": depth, width and height must be above 0");
      continue;
    }
    out->push_back({{v[0], v[1]}, v[2], v[3], v[4], v[5]});
  }
}

void ReadWorld(const YAML::Node& node, YamlReport* report, Scenario* s) {
  WorldConfig* world = &s->world;
  StrictMap map(node, "world", report);
  map.Choice<WallStyle>("walls", &world->walls,
                        {{"textured", WallStyle::kTextured},
                         {"mixed", WallStyle::kMixed},
                         {"faint", WallStyle::kFaint},
                         {"blank", WallStyle::kBlank},
                         {"repetitive", WallStyle::kRepetitive}});
  map.Choice<FloorStyle>(
      "floor", &world->floor,
      {{"wood", FloorStyle::kWood}, {"carpet", FloorStyle::kCarpet}, {"lino", FloorStyle::kLino}});
  map.Number("ceiling_m", &world->ceiling_m, 1.5, 20);
  map.Number("posters_per_m", &world->posters_per_m, 0, 2);
  map.Number("doors_per_m", &world->doors_per_m, 0, 2);
  map.Number("furniture_per_m", &world->furniture_per_m, 0, 2);
  map.Number("lamp_spacing_m", &world->lamp_spacing_m, 0.8, 20);
  map.Number("light", &s->light, 0.001, 10);
  ReadRegions(&map, "blank_regions", &world->blank_regions);
  ReadRegions(&map, "carpets", &world->carpets);
  ReadBoxes(&map, "boxes", &world->boxes);
  std::vector<double> repeat;
  map.Numbers("repeat_m", &repeat, 2);
  if (repeat.size() == 2) world->repeat_m = {repeat[0], repeat[1]};
  map.Finish();
}

void ReadCamera(const YAML::Node& node, YamlReport* report, Scenario* s) {
  StrictMap map(node, "camera", report);
  map.Choice<CameraMode>("mode", &s->camera,
                         {{"stereo", CameraMode::kStereo}, {"rgbd", CameraMode::kRgbd}});
  map.Integer("width", &s->pinhole.width, 64, 4096);
  map.Integer("height", &s->pinhole.height, 64, 4096);
  s->pinhole.cx = s->pinhole.width / 2.0;
  s->pinhole.cy = s->pinhole.height / 2.0;
  map.Number("focal_px", &s->pinhole.fx, 20, 10000);
  s->pinhole.fy = s->pinhole.fx;
  map.Number("baseline_m", &s->depth.baseline_m, 0.005, 1);
  map.Number("rate_hz", &s->camera_rate_hz, 1, 120);
  map.Number("max_exposure_ms", &s->imager.max_exposure_ms, 0.05, 30);
  map.Number("max_gain", &s->imager.max_gain, 1, 64);
  map.Number("read_noise_grey", &s->imager.read_noise_grey, 0, 10);
  map.Number("electrons_per_grey", &s->imager.electrons_per_grey, 1, 1000);
  map.Number("disparity_sigma_px", &s->depth.disparity_sigma_px, 0, 5);
  map.Number("disparity_step_px", &s->depth.disparity_step_px, 1e-4, 2);
  bool projector = false;
  map.Flag("projector", &projector);
  if (projector) s->depth.min_contrast_grey = 0;
  std::vector<double> position;
  map.Numbers("position_m", &position, 3);
  if (position.size() == 3) s->camera_position = {position[0], position[1], position[2]};
  double up_deg = 0;
  map.Number("up_deg", &up_deg, -45, 45);
  s->camera_up_rad = up_deg * std::numbers::pi / 180;
  map.Finish();
}

void ReadImu(const YAML::Node& node, YamlReport* report, ImuConfig* imu) {
  StrictMap map(node, "imu", report);
  map.Number("rate_hz", &imu->rate_hz, 20, 1000);
  map.Number("gyro_noise", &imu->gyro_noise, 1e-7, 1);
  map.Number("gyro_walk", &imu->gyro_walk, 0, 1);
  map.Number("gyro_bias", &imu->gyro_bias, 0, 1);
  map.Number("gyro_scale_error", &imu->gyro_scale_error, 0, 0.2);
  map.Number("accel_noise", &imu->accel_noise, 1e-6, 10);
  map.Number("accel_walk", &imu->accel_walk, 0, 10);
  map.Number("accel_bias", &imu->accel_bias, 0, 5);
  map.Number("shake_rad_s", &imu->shake_rad_s, 0, 1);
  map.Number("shake_m_s2", &imu->shake_m_s2, 0, 10);
  map.Finish();
}

void ReadBase(const YAML::Node& node, YamlReport* report, Scenario* s) {
  StrictMap map(node, "base", report);
  map.Number("dead_time_s", &s->base.dead_time_s, 0, 1);
  map.Number("lag_s", &s->base.lag_s, 0.002, 1);
  map.Number("scale_error", &s->base.scale_error, 0, 0.2);
  map.Number("wheel_difference", &s->base.wheel_difference, 0, 0.1);
  map.Number("track_error", &s->base.track_error, 0, 0.2);
  map.Number("slip_per_sqrt_m", &s->base.slip_per_sqrt_m, 0, 0.5);
  map.Number("heading_deg_per_sqrt_m", &s->base.heading_deg_per_sqrt_m, 0, 30);
  map.Number("carpet_factor", &s->base.carpet_factor, 1, 20);
  map.Number("side_slip", &s->base.side_slip, 0, 1);
  map.Number("sideways_per_sqrt_m", &s->base.sideways_per_sqrt_m, 0, 0.5);
  map.Number("track_factor", &s->base.track_factor, 0.5, 4);
  map.Number("turn_centre_m", &s->base.turn_centre_m, 0, 0.3);
  map.Number("turn_deg_per_sqrt_rad", &s->base.turn_deg_per_sqrt_rad, 0, 30);
  map.Number("wheel_delay_s", &s->odometry.delay_s, 0, 0.2);
  map.Number("odometry_hz", &s->odometry.rate_hz, 0, 50);
  map.Number("stamp_jitter_ms", &s->odometry.stamp_jitter_ms, 0, 20);
  map.Number("floor_roughness", &s->floor_roughness, 0, 10);
  map.Finish();
}

void ReadMounting(const YAML::Node& node, YamlReport* report, MountingConfig* mounting) {
  StrictMap map(node, "mounting", report);
  map.Number("camera_deg", &mounting->camera_deg, 0, 10);
  map.Number("camera_m", &mounting->camera_m, 0, 0.2);
  map.Finish();
}

void ReadDrive(const YAML::Node& node, YamlReport* report, FollowerConfig* drive) {
  StrictMap map(node, "drive", report);
  map.Number("max_m_s", &drive->pursuit.max_v, 0.05, 0.7);
  double max_deg_s = drive->pursuit.max_w * 180 / std::numbers::pi;
  map.Number("max_deg_s", &max_deg_s, 5, 110);
  drive->pursuit.max_w = max_deg_s * std::numbers::pi / 180;
  map.Flag("turn_at_waypoints", &drive->turn_at_waypoints);
  map.Number("pause_s", &drive->pause_s, 0, 60);
  map.Finish();
}

void ReadRecorded(const YAML::Node& node, YamlReport* report, RecordedConfig* recorded) {
  StrictMap map(node, "recorded", report);
  map.Number("length_m", &recorded->length_m, 1, 1e9);
  map.Number("every_m", &recorded->every_m, 5, 1e9);
  map.Number("dark_s", &recorded->dark_s, 0, 600);
  map.Number("bare_m", &recorded->bare_m, 0, 1000);
  map.Finish();
}

void ReadEvent(const YAML::Node& node, const std::string& path, YamlReport* report,
               std::vector<Event>* out) {
  StrictMap map(node, path, report);
  Event event;
  map.Choice<EventKind>("kind", &event.kind, kEventKinds, true);
  map.Number("at_s", &event.at_s, 0, kFar, true);
  if (event.kind != EventKind::kKidnap) map.Number("for_s", &event.for_s, 0.001, kFar, true);
  switch (event.kind) {
    case EventKind::kLightsOff:
      map.Number("level", &event.level, 0, 1);
      break;
    case EventKind::kGlare:
      map.Number("strength", &event.strength, 0, 100);
      map.Number("azimuth_deg", &event.azimuth_deg, -360, 360);
      break;
    case EventKind::kSlip:
      map.Number("traction", &event.traction, 0, 1.5);
      break;
    case EventKind::kPush:
      map.Number("dx", &event.dx, -5, 5);
      map.Number("dy", &event.dy, -5, 5);
      map.Number("dyaw_deg", &event.dyaw_deg, -360, 360);
      break;
    case EventKind::kKidnap: {
      std::vector<double> to;
      map.Numbers("to", &to, 3, true);
      if (to.size() == 3) event.to = {{to[0], to[1]}, to[2]};
      break;
    }
    case EventKind::kDropFrames:
      map.Number("share", &event.share, 0, 1);
      break;
    case EventKind::kLateFrames:
      map.Number("delay_ms", &event.delay_ms, 0, 1000);
      break;
    case EventKind::kLensCovered:
      break;
  }
  map.Finish();
  out->push_back(event);
}

Result<Scenario> Read(const YAML::Node& root, const std::string& name) {
  YamlReport report(name);
  Scenario s;
  StrictMap map(root, "", &report);
  map.Text("name", &s.name, true);
  std::string ignored;
  map.Text("description", &ignored);
  map.Text("map", &s.map);
  ReadWaypoints(&map, &s.waypoints);
  ReadVisit(&map, &s.visit);
  map.Integer("laps", &s.laps, 1, 1000);
  map.Integer("seed", &s.seed, 0, 2'000'000'000);
  map.Number("max_duration_s", &s.max_duration_s, 0.1, 36000);
  map.Number("rest_s", &s.rest_s, 0, 600);
  const auto section = [&map](const char* key, const auto& read) {
    const YAML::Node node = map.Take(key);
    if (node.IsDefined()) read(node);
  };
  section("world", [&](const YAML::Node& n) { ReadWorld(n, &report, &s); });
  section("camera", [&](const YAML::Node& n) { ReadCamera(n, &report, &s); });
  section("imu", [&](const YAML::Node& n) { ReadImu(n, &report, &s.imu); });
  section("base", [&](const YAML::Node& n) { ReadBase(n, &report, &s); });
  section("mounting", [&](const YAML::Node& n) { ReadMounting(n, &report, &s.mounting); });
  section("drive", [&](const YAML::Node& n) { ReadDrive(n, &report, &s.drive); });
  section("recorded", [&](const YAML::Node& n) { ReadRecorded(n, &report, &s.recorded); });
  section("events", [&](const YAML::Node& n) {
    if (!n.IsSequence()) report.Add(n, "events: must be a list");
    int index = 0;
    for (const auto& event : n) {
      ReadEvent(event, "events[" + std::to_string(index++) + "]", &report, &s.events);
    }
  });
  map.Finish();
  for (const int index : s.visit) {
    if (!s.waypoints.empty() && index >= static_cast<int>(s.waypoints.size())) {
      report.Add(root, "visit: there is no waypoint " + std::to_string(index));
    }
  }
  if (!report.empty()) return Error{ErrorCode::kBadConfig, report.Text()};
  return s;
}

}  // namespace

const char* EventName(EventKind kind) {
  for (const auto& [name, value] : kEventKinds) {
    if (value == kind) return name;
  }
  return "";
}

Result<Scenario> ParseScenario(const std::string& text, const std::string& name) {
  try {
    return Read(YAML::Load(text), name);
  } catch (const YAML::Exception& e) {
    return Error{ErrorCode::kBadConfig, name + ":" + std::to_string(std::max(0, e.mark.line) + 1) +
                                            ": not valid YAML: " + e.msg};
  }
}

Result<Scenario> LoadScenario(const std::string& path) {
  const Result<std::string> text = tools::ReadTextFile(path);
  if (!text) return text.error();
  Result<Scenario> scenario = ParseScenario(*text, path);
  if (scenario.ok() && !scenario->map.empty()) {
    scenario->map = (std::filesystem::path(path).parent_path() / scenario->map).string();
  }
  return scenario;
}

}  // namespace gw::sim

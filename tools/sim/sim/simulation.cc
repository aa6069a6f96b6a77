#include "tools/sim/sim/simulation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/core/format.h"
#include "common/core/random.h"
#include "common/core/version.h"
#include "common/wire/channels.h"
#include "tools/robot/floorplan/planner.h"
#include "tools/sim/sim/hard_way.h"

namespace gw::sim {
namespace {

constexpr double kStep = 0.001;    // s
constexpr double kWheelRate = 50;  // Hz
constexpr int kTruthEveryMs = 10;
constexpr int kControlEveryMs = 50;
constexpr int kObeyEveryMs = 20;     // as gw-kobuki
constexpr double kClearance = 0.06;  // m beside the robot that the planned way keeps free
constexpr double kRunOut = 1.0;      // s after the last stop
constexpr DurationUs kImageTransfer = Milliseconds(14);  // from the end of the exposure
constexpr DurationUs kImuTransfer = Milliseconds(4);
constexpr double kSunElevation = 0.2;  // rad

// Order of messages that arrive at the same microsecond.
enum Rank { kNoteRank, kTruthRank, kImuRank, kWheelRank, kCameraRank };

RobotConfig MakeRobotConfig(const Scenario& s) {
  RobotConfig c;
  c.robot.name = "sim_" + s.name;
  CameraCalibration& camera = c.calibration.camera;
  camera.kind = s.camera == CameraMode::kStereo ? CameraKind::kStereo : CameraKind::kRgbd;
  camera.width = s.pinhole.width;
  camera.height = s.pinhole.height;
  camera.rate_hz = s.camera_rate_hz;
  camera.left.fx = s.pinhole.fx;
  camera.left.fy = s.pinhole.fy;
  camera.left.cx = s.pinhole.cx;
  camera.left.cy = s.pinhole.cy;
  if (camera.kind == CameraKind::kStereo) {
    camera.right = camera.left;
    camera.T_C0C1 = SE3(Eigen::Quaterniond::Identity(), {s.depth.baseline_m, 0, 0});
  }
  camera.depth_unit_m = s.depth.unit_m;
  camera.depth_min_m = s.depth.min_m;
  camera.depth_max_m = 6.0;
  camera.depth_baseline_m = s.depth.baseline_m;
  camera.disparity_sigma_px = s.depth.disparity_sigma_px;
  const Eigen::Quaterniond up(Eigen::AngleAxisd(-s.camera_up_rad, Eigen::Vector3d::UnitY()));
  const Eigen::Quaterniond q_BC = up * Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5);
  camera.T_BC = SE3(q_BC, s.camera_position);
  ImuCalibration& imu = c.calibration.imu;
  imu.present = true;
  imu.has_accel = true;
  imu.rate_hz = s.imu.rate_hz;
  // In the camera's housing, as in config/robots/turtlebot2_d435i.yaml.
  const Eigen::Vector3d from_eye(0.1117 - 0.1, 0.023 - 0.0175, 0.2449 - 0.25);
  imu.T_BI = SE3(q_BC, s.camera_position + up * from_eye);
  imu.gyro_noise = s.imu.gyro_noise;
  imu.gyro_walk = s.imu.gyro_walk;
  imu.accel_noise = s.imu.accel_noise;
  imu.accel_walk = s.imu.accel_walk;
  WheelCalibration& wheel = c.calibration.wheel;
  wheel.present = true;
  wheel.rate_hz = s.odometry.rate_hz > 0 ? s.odometry.rate_hz : kWheelRate;
  wheel.time_offset_s = s.odometry.delay_s;
  wheel.track_width_m = s.base.track_m;
  return c;
}

ImageView View(const Pinhole& camera, const void* data, PixelFormat format) {
  return {static_cast<const uint8_t*>(data), camera.width, camera.height,
          camera.width * BytesPerPixel(format), format};
}

uint64_t NoiseKey(uint64_t seed, int64_t frame, uint64_t eye) {
  return CounterRng(seed, 0xE7E + eye, static_cast<uint64_t>(frame)).NextU64();
}

}  // namespace

Simulation::Simulation(const Scenario& scenario, Drive drive, Utime start, int threads)
    : scenario_(scenario),
      drive_(drive),
      start_(start),
      now_(start),
      robot_config_(MakeRobotConfig(scenario)),
      T_BC_(MountedAt(robot_config_.calibration.camera.T_BC, scenario.mounting, scenario.seed)),
      // The IMU is in the camera, whose maker knows where.
      T_BI_(T_BC_ * robot_config_.calibration.camera.T_BC.inverse() *
            robot_config_.calibration.imu.T_BI),
      pool_(threads),
      shaper_(robot_config_.drivers.kobuki),
      floor_(scenario.seed, scenario.floor_roughness),
      left_eye_(scenario.pinhole, scenario.imager, &pool_),
      right_eye_(scenario.pinhole, scenario.imager, &pool_),
      auto_exposure_(scenario.imager),
      imu_(scenario.imu, T_BI_, scenario.seed),
      wheels_(scenario.base.track_m, robot_config_.calibration.wheel.ticks_per_metre,
              scenario.seed),
      odometry_(scenario.odometry, start, scenario.seed) {}

// Whoever drives from outside passes over stops that cannot be visited, so that they are left out;
// not the first, where the robot stands.
Result<std::vector<floorplan::Leg>> Simulation::PlanStops(const floorplan::FloorMap& map,
                                                          double clearance) {
  if (drive_ != Drive::kExternal) return floorplan::PlanLegs(map, stops_, clearance);
  floorplan::Tour tour = floorplan::PlanTour(map, stops_, clearance);
  if (tour.visited.empty() || tour.visited.front() != 0) {
    return floorplan::PlanLegs(map, {stops_.front()}, clearance);
  }
  std::vector<floorplan::Waypoint> visited;
  for (const int stop : tour.visited) visited.push_back(stops_[stop]);
  stops_ = std::move(visited);
  return std::move(tour.legs);
}

Result<std::unique_ptr<Simulation>> Simulation::Create(const Scenario& scenario,
                                                       const floorplan::FloorMap& map, Drive drive,
                                                       Utime start, int threads) {
  std::unique_ptr<Simulation> sim(new Simulation(scenario, drive, start, threads));
  std::stable_sort(sim->scenario_.events.begin(), sim->scenario_.events.end(),
                   [](const Event& a, const Event& b) { return a.at_s < b.at_s; });
  for (const int index : floorplan::StopsOfLaps(static_cast<int>(scenario.waypoints.size()),
                                                scenario.visit, scenario.laps)) {
    sim->stops_.push_back(scenario.waypoints[index]);
  }
  if (sim->stops_.empty()) {
    return Error{ErrorCode::kBadData,
                 "no waypoints: give --waypoints, or `waypoints` in the scenario"};
  }
  const double clearance = scenario.base.radius_m + kClearance;
  sim->stops_ = floorplan::MoveStopsFromWalls(map, std::move(sim->stops_), clearance);
  const auto legs = sim->PlanStops(map, clearance);
  if (!legs) return legs.error();
  std::vector<Eigen::Vector2d> keep_free;
  for (const floorplan::Waypoint& stop : sim->stops_) keep_free.push_back(stop.position);
  for (const floorplan::Leg& leg : *legs) keep_free.insert(keep_free.end(), leg.begin(), leg.end());
  for (const Event& event : scenario.events) {
    if (event.kind != EventKind::kKidnap) continue;
    keep_free.push_back(event.to.position);
    const auto way = floorplan::PlanLegs(map, {event.to, sim->stops_.front()}, clearance);
    if (!way) return Error{ErrorCode::kBadData, "kidnap: " + way.error().message};
    keep_free.insert(keep_free.end(), way->front().begin(), way->front().end());
  }
  sim->Build(map, sim->stops_.front(), keep_free);
  sim->follower_ = std::make_unique<PathFollower>(sim->stops_, *legs, scenario.drive);
  return sim;
}

Result<std::unique_ptr<Simulation>> Simulation::Create(const Scenario& scenario,
                                                       const floorplan::FloorMap& map,
                                                       RecordedMotion motion, Utime start,
                                                       int threads) {
  std::unique_ptr<Simulation> sim(new Simulation(scenario, Drive::kPath, start, threads));
  MakeWayHard(motion, &sim->scenario_);
  std::erase_if(sim->scenario_.events,
                [](const Event& event) { return event.kind == EventKind::kKidnap; });
  std::stable_sort(sim->scenario_.events.begin(), sim->scenario_.events.end(),
                   [](const Event& a, const Event& b) { return a.at_s < b.at_s; });
  std::vector<Eigen::Vector2d> way;
  for (double t = 0; t <= motion.duration_s(); t += 0.1) way.push_back(motion.At(t).position);
  for (const Eigen::Vector2d& p : way) {
    const Eigen::Vector2i cell = map.CellOf(p);
    if (!map.InMap(cell.x(), cell.y()) || map.Occupied(cell.x(), cell.y())) {
      return Error{ErrorCode::kBadData, "the trajectory leaves the map or enters a wall"};
    }
  }
  const RecordedMotion::Planar first = motion.At(0);
  sim->robot_config_.calibration.wheel.time_offset_s = 0;
  sim->robot_config_.calibration.wheel.rate_hz = std::round(motion.odometry_rate_hz());
  sim->robot_config_.calibration.imu.present = motion.TellsRates();
  sim->recorded_ = std::move(motion);
  sim->Build(map, {first.position, first.yaw}, way);
  sim->follower_ = std::make_unique<PathFollower>(std::vector<floorplan::Waypoint>{},
                                                  std::vector<floorplan::Leg>{}, scenario.drive);
  return sim;
}

void Simulation::Build(const floorplan::FloorMap& map, const floorplan::Waypoint& first,
                       const std::vector<Eigen::Vector2d>& keep_free) {
  const auto seed = static_cast<uint64_t>(scenario_.seed);
  world_ = std::make_unique<World>(map, scenario_.world, first.position, keep_free, seed);
  contacts_ = world_->Contacts(scenario_.base.height_m);
  distance_ = floorplan::DistanceToOccupied(contacts_, 2.0);
  base_ = std::make_unique<Base>(scenario_.base, contacts_, distance_, seed);
  base_->Place(first.position, first.yaw);
  renderer_ = std::make_unique<Renderer>(*world_, scenario_.pinhole, &pool_);
  T_GB_ = floor_.BodyPose(first.position, first.yaw);
  p_GI_ = T_GB_ * T_BI_.translation();
  Note("source", std::string("gw-sim ") + Version() + " scenario " + scenario_.name + " seed " +
                     std::to_string(scenario_.seed) +
                     (recorded_ ? ", along a recorded robot's way with its odometry" : "") +
                     (robot_config_.calibration.imu.present
                          ? ""
                          : ", without an IMU: the recorded poses are too far apart to tell one"));
}

void Simulation::SendRecordedOdometry() {
  const auto& odometry = recorded_->odometry();
  for (; next_odometry_ < odometry.size() && odometry[next_odometry_].t <= seconds();
       ++next_odometry_) {
    const auto& before = odometry[next_odometry_ - 1];
    const auto& now = odometry[next_odometry_];
    const SE3 step = before.T_OB.inverse() * now.T_OB;
    WheelSample sample;
    sample.utime_begin = start_ + DurationFromSeconds(before.t);
    sample.utime = start_ + DurationFromSeconds(now.t);
    sample.seq = wheel_count_++;
    sample.dx_m = step.translation().x();
    sample.dy_m = step.translation().y();
    sample.dyaw_rad = LogSO3(step.rotation()).z();
    Send(now_, kWheelRank, wire::kWheel, wire::Encode(sample));
  }
}

int Simulation::stops_reached() const {
  return std::min(num_stops(), 1 + legs_before_replan_ + follower_->legs_done());
}

void Simulation::Send(Utime arrival, int rank, std::string_view channel, wire::Bytes message) {
  pending_.emplace(std::make_tuple(arrival.us, rank, made_++),
                   Outgoing{arrival, channel, std::move(message)});
}

std::vector<Outgoing> Simulation::Take(bool all) {
  std::vector<Outgoing> out;
  while (!pending_.empty() && (all || pending_.begin()->second.arrival <= now_)) {
    out.push_back(std::move(pending_.begin()->second));
    pending_.erase(pending_.begin());
  }
  return out;
}

void Simulation::Note(const std::string& key, const std::string& text) {
  Send(now_, kNoteRank, wire::kNote, wire::Encode(wire::Note{now_, ++note_seq_, key, text}));
}

void Simulation::Truth(Utime at, const SE3& T_GB) {
  if (truth_seq_ > 0 && at <= last_truth_) return;
  last_truth_ = at;
  Send(at, kTruthRank, wire::kGroundTruth, wire::Encode(GroundTruth{at, ++truth_seq_, T_GB}));
}

void Simulation::Command(const BaseCommand& command) {
  commands_refused_ += !shaper_.Push(command, now_);
}

Result<Done> Simulation::Replan(const floorplan::Waypoint& from) {
  legs_before_replan_ += follower_->legs_done();
  std::vector<floorplan::Waypoint> stops = {from};
  stops.insert(stops.end(), stops_.begin() + std::min(num_stops(), legs_before_replan_ + 1),
               stops_.end());
  auto legs = floorplan::PlanLegs(world_->obstacles(), stops, scenario_.base.radius_m + kClearance);
  if (!legs) return legs.error();
  follower_ = std::make_unique<PathFollower>(stops, *legs, scenario_.drive);
  return Done{};
}

void Simulation::BeginEvents() {
  const double t = seconds();
  for (; next_event_ < scenario_.events.size() && scenario_.events[next_event_].at_s <= t;
       ++next_event_) {
    const Event& event = scenario_.events[next_event_];
    const Eigen::Vector2d& to = event.to.position;
    Note(std::string("event.") + EventName(event.kind),
         event.kind == EventKind::kKidnap
             ? "to (" + FormatFixed(to.x(), 2) + ", " + FormatFixed(to.y(), 2) + ") m"
             : "for " + FormatFixed(event.for_s, 1) + " s");
    if (event.kind != EventKind::kKidnap) continue;
    base_->Place(event.to.position, event.to.yaw);
    T_GB_ = floor_.BodyPose(event.to.position, event.to.yaw);
    p_GI_ = T_GB_ * T_BI_.translation();
    imu_.Forget();
    wheels_.Forget(event.to.yaw);
    if (drive_ == Drive::kPath && !Replan(event.to)) finished_at_s_ = t;
  }
}

Disturbance Simulation::DisturbanceNow() const {
  const double t = seconds();
  Disturbance d;
  for (const Event& event : scenario_.events) {
    if (!event.ActiveAt(t)) continue;
    if (event.kind == EventKind::kSlip) d.traction *= event.traction;
    if (event.kind == EventKind::kPush) {
      // Smooth: speed zero at both ends.
      const double speed =
          (1 - std::cos(2 * std::numbers::pi * (t - event.at_s) / event.for_s)) / event.for_s;
      d.push_v += speed * Eigen::Vector2d(event.dx, event.dy);
      d.push_w += speed * event.dyaw_deg * std::numbers::pi / 180;
    }
  }
  d.on_carpet = std::any_of(scenario_.world.carpets.begin(), scenario_.world.carpets.end(),
                            [this](const Region& r) { return r.Contains(base_->position()); });
  return d;
}

void Simulation::FollowPath() {
  const double t = seconds();
  if (t < scenario_.rest_s) return;
  const floorplan::Speed speed = follower_->Update(t, base_->position(), base_->yaw());
  base_->Command(t, speed.v, speed.w);
  if (follower_->finished() && finished_at_s_ < 0) finished_at_s_ = t;
}

void Simulation::ObeyCommand() {
  guard_.Sense({.bumper = base_->bumper()}, now_);
  kobuki::Twist driving = shaper_.Step(guard_.Filter(shaper_.Wanted(now_), now_), now_);
  if (guard_.stop() != kobuki::SafetyGuard::Stop::kNone && driving.v_m_s > 0) {
    shaper_.Halt();
    driving = {};
  }
  base_->Command(seconds(), driving.v_m_s, driving.w_rad_s);
}

bool Simulation::Step() {
  const double t = seconds();
  if (t >= scenario_.max_duration_s || (finished_at_s_ >= 0 && t >= finished_at_s_ + kRunOut)) {
    return false;
  }
  if (recorded_ && t >= recorded_->duration_s()) return false;
  BeginEvents();
  const int64_t ms = (now_ - start_).us / 1000;
  if (recorded_) {
    const RecordedMotion::Planar at = recorded_->At(t + kStep);
    base_->Place(at.position, at.yaw);
  } else {
    if (drive_ == Drive::kPath && ms % kControlEveryMs == 0) FollowPath();
    if (drive_ == Drive::kExternal && ms % kObeyEveryMs == 0) ObeyCommand();
    base_->Step(t, kStep, DisturbanceNow());
  }
  bumper_hit_ = bumper_hit_ || base_->bumper();
  const SE3 T_before = T_GB_;
  const Utime before = now_;
  T_GB_ = floor_.BodyPose(base_->position(), base_->yaw());
  now_ = now_ + Milliseconds(1);
  Measure(T_before, before);
  return true;
}

void Simulation::Measure(const SE3& T_GB_before, Utime before) {
  const double t = seconds();
  const Eigen::Vector3d p_GI = T_GB_ * T_BI_.translation();
  const Eigen::Vector3d v_GI = (p_GI - p_GI_) / kStep;
  p_GI_ = p_GI;
  // Samples of every sensor are at multiples of its period, rounded down to the step.
  if (robot_config_.calibration.imu.present &&
      t * scenario_.imu.rate_hz >= static_cast<double>(imu_count_ + 1) - 1e-9) {
    ++imu_count_;
    const ImuSample sample =
        imu_.Measure(now_, 1 / scenario_.imu.rate_hz, T_GB_, v_GI, std::abs(base_->v()));
    Send(now_ + kImuTransfer, kImuRank, wire::kImu, wire::Encode(sample));
  }
  if (recorded_) {
    SendRecordedOdometry();
  } else if (t * kWheelRate >= static_cast<double>(wheel_count_ + 1) - 1e-9) {
    ++wheel_count_;
    odometry_.Push(wheels_.Measure(now_, base_->left_way(), base_->right_way(), base_->yaw(),
                                   base_->bumper()));
  }
  if (const auto sample = recorded_ ? std::nullopt : odometry_.Take(now_)) {
    Send(sample->utime, kWheelRank, wire::kWheel, wire::Encode(*sample));
  }
  const auto frame_time = [this](int64_t frame) {
    return start_ + DurationFromSeconds(static_cast<double>(frame) / scenario_.camera_rate_hz);
  };
  while (frame_time(frame_ + 1) <= now_) {
    const Utime at = frame_time(++frame_);
    const double fraction = (at - before).seconds() / kStep;
    CameraMotion motion;
    const Vector6d tangent = ((T_GB_before * T_BC_).inverse() * T_GB_ * T_BC_).Log() / kStep;
    motion.v = tangent.head<3>();
    motion.w = tangent.tail<3>();
    const SE3 T_GB = Interpolate(T_GB_before, T_GB_, fraction);
    Truth(at, T_GB);
    TakeImage(at, T_GB, motion);
  }
  if ((now_ - start_).us % (1000 * kTruthEveryMs) == 0) Truth(now_, T_GB_);
}

void Simulation::TakeImage(Utime at, const SE3& T_GB, const CameraMotion& motion) {
  const double t = (at - start_).seconds();
  const auto seed = static_cast<uint64_t>(scenario_.seed);
  double light = scenario_.light;
  Glare glare;
  DurationUs late{0};
  bool dropped = false;
  const SE3 T_GC = T_GB * T_BC_;
  for (const Event& event : scenario_.events) {
    if (!event.ActiveAt(t)) continue;
    switch (event.kind) {
      case EventKind::kLightsOff:
        light *= event.level;
        break;
      case EventKind::kLensCovered:
        light = 0;
        break;
      case EventKind::kGlare: {
        const double azimuth = event.azimuth_deg * std::numbers::pi / 180;
        const Eigen::Vector3d sun =
            T_GC.rotation().conjugate() *
            Eigen::Vector3d(std::cos(azimuth) * std::cos(kSunElevation),
                            std::sin(azimuth) * std::cos(kSunElevation), std::sin(kSunElevation));
        if (sun.z() < 0.2) break;
        glare.strength = event.strength;
        glare.x = scenario_.pinhole.cx + scenario_.pinhole.fx * sun.x() / sun.z();
        glare.y = scenario_.pinhole.cy + scenario_.pinhole.fy * sun.y() / sun.z();
        break;
      }
      case EventKind::kDropFrames:
        dropped = dropped ||
                  CounterRng(seed, 0xD40, static_cast<uint64_t>(frame_)).Uniform() < event.share;
        break;
      case EventKind::kLateFrames:
        late = DurationFromSeconds(event.delay_ms * 1e-3);
        break;
      default:
        break;
    }
  }
  if (light <= 0) glare = {};
  const Exposure exposure = auto_exposure_.exposure();
  renderer_->Render(T_GC, light, &left_scene_);
  left_eye_.Expose(left_scene_, motion, exposure, glare, NoiseKey(seed, frame_, 0), &left_image_);
  auto_exposure_.Observe(MeanGrey(left_image_));
  if (dropped) return;
  CameraFrame frame;
  frame.utime = at;
  frame.seq = frame_;
  frame.exposure_us = static_cast<int32_t>(std::lround(exposure.time_ms * 1000));
  frame.emitter = EmitterState::kOff;
  frame.left = View(scenario_.pinhole, left_image_.data(), PixelFormat::kGray8);
  if (scenario_.camera == CameraMode::kStereo) {
    const SE3 T_GC1 = T_GC * robot_config_.calibration.camera.T_C0C1;
    renderer_->Render(T_GC1, light, &right_scene_);
    right_eye_.Expose(right_scene_, motion, exposure, glare, NoiseKey(seed, frame_, 1),
                      &right_image_);
    frame.right = View(scenario_.pinhole, right_image_.data(), PixelFormat::kGray8);
  } else {
    MeasureDepth(left_scene_, left_eye_.signal(), scenario_.pinhole, scenario_.depth,
                 NoiseKey(seed, frame_, 2), &pool_, &depth_image_);
    frame.depth = View(scenario_.pinhole, depth_image_.data(), PixelFormat::kDepth16);
  }
  const DurationUs open = DurationFromSeconds(exposure.time_ms * 0.5e-3);
  Send(at + open + kImageTransfer + late, kCameraRank, wire::kCamera, wire::Encode(frame));
}

}  // namespace gw::sim

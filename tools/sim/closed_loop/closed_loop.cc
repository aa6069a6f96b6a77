#include "tools/sim/closed_loop/closed_loop.h"

#include <cmath>
#include <utility>

#include "common/wire/channels.h"

namespace gw::sim {
namespace {

constexpr int kGridEveryMs = 500;
constexpr int kControlEveryMs = 1000 / navigate::Driver::kRateHz;
constexpr double kMoving = 0.02;  // m/s

}  // namespace

ClosedLoop::ClosedLoop(std::unique_ptr<Simulation> sim, const RobotConfig& config,
                       const CameraGeometry& geometry, tools::SlamSession slam,
                       std::unique_ptr<navigate::Driver> driver, const SE3& T_MG, const SE3& T_MW,
                       const ClosedLoopOptions& options)
    : sim_(std::move(sim)),
      slam_(std::move(slam)),
      driver_(std::move(driver)),
      T_MG_(T_MG),
      T_MW_(T_MW),
      options_(options),
      glide_(options.rates),
      looks_(geometry, config.grid),
      obstacles_(config.grid, config.navigate.robot_radius_m),
      grid_(config.grid, geometry.rectified.T_BC, config.navigate.robot_radius_m) {}

Result<std::unique_ptr<ClosedLoop>> ClosedLoop::Create(std::unique_ptr<Simulation> sim,
                                                       const RobotConfig& config,
                                                       tools::MapStart start,
                                                       std::unique_ptr<navigate::Driver> driver,
                                                       const SE3& T_MG, const SE3& T_MW,
                                                       const ClosedLoopOptions& options) {
  const auto geometry = MakeCameraGeometry(config.calibration);
  if (!geometry) return geometry.error();
  auto slam = tools::SlamSession::Create(config, std::move(start));
  if (!slam) return slam.error();
  std::unique_ptr<ClosedLoop> loop(new ClosedLoop(
      std::move(sim), config, *geometry, *std::move(slam), std::move(driver), T_MG, T_MW, options));
  loop->Watch();
  return loop;
}

void ClosedLoop::Watch() {
  slam_.WatchDr([this](const dr_ekf::DrFilter::Output& output) {
    for (const DrState& state : output.states) TakeState(state);
  });
  slam_.WatchMapping(
      {[this](const CameraFrame& frame, const FramePose& pose) { TakeImage(frame, pose); },
       [this](const MapUpdate& update) { grid_session_ += grid_.Apply(update) ? 1 : 0; }});
}

void ClosedLoop::TakeState(const DrState& state) {
  dr_.Push(state);
  const auto composed = composer_.Push(state);
  if (!composed) return;
  const Pose pose = glide_.Push(*composed, state.stationary);
  steps_.Push(*composed, pose, state.stationary);
  if (options_.truth) return;
  if (!pose.has_map) {
    driver_->Push(std::nullopt);
    return;
  }
  TellPose(navigate::OnMap(T_MW_, pose));
}

void ClosedLoop::TellPose(const navigate::RobotPose& pose) {
  pose_ = pose;
  driver_->Push(pose);
  if (on_pose) on_pose(pose);
}

void ClosedLoop::TakeImage(const CameraFrame& frame, const FramePose& pose) {
  frame_ = pose;
  if (!looks_.Due(frame.utime)) return;
  const auto scan = looks_.Look(frame, grid_.length_factor());
  if (!scan) return;
  grid_.Add(pose, *scan);
  const uint32_t epoch = dr_.empty() ? 0 : dr_.newest().reset_counter;
  const ObstacleView view = obstacles_.Push(frame.utime, dr_.PoseAt(frame.utime), epoch, *scan);
  sees_ = view.seen_ahead_m > 0;
  if (options_.obstacles) driver_->See(view);
}

// As gw-grid does: what changed, twice a second.
void ClosedLoop::SendGrid() {
  GridUpdate update;
  update.tiles = grid_.Compose();
  update.utime = grid_.utime();
  update.seq = ++grid_seq_;
  update.grid_session = grid_session_;
  update.grid_version = grid_.version();
  update.map_revision = grid_.map_revision();
  update.cell_m = grid_.cell_m();
  driver_->Take(update, sim_->now());
}

void ClosedLoop::TakeTruth(const GroundTruth& truth) {
  const navigate::RobotPose on_map = navigate::OnMap({truth.utime, truth.seq, T_MG_ * truth.T_GB});
  truth_ = on_map;
  if (options_.truth) TellPose(on_map);
  if (on_truth) on_truth(on_map);
}

void ClosedLoop::Deliver(const Outgoing& message) {
  if (message.channel == wire::kGroundTruth) {
    if (const auto truth = wire::Decode<GroundTruth>(message.message)) TakeTruth(*truth);
    return;
  }
  slam_.Process({0, message.arrival, message.channel, message.message});
  // As on the bus, FRAME_POSE comes to the DR filter first, then to the composer.
  if (frame_) composer_.Push(*std::exchange(frame_, std::nullopt));
  if (message.channel != wire::kWheel) return;
  const auto wheel = wire::Decode<WheelSample>(message.message);
  if (!wheel) return;
  driver_->Sense(wheel->contact);
  TakeContact(wheel->contact);
}

void ClosedLoop::TakeContact(const ContactFlags& contact) {
  const bool begins = contact.bumper && !pressed_;
  pressed_ = contact.bumper;
  if (!begins) return;
  const navigate::RobotPose truth = truth_.value_or(navigate::RobotPose{});
  const double error = pose_ ? (pose_->position - truth.position).norm() : 0;
  report_.contacts.push_back({sim_->seconds(), truth, error});
}

void ClosedLoop::Control() {
  const double dt = 1.0 / navigate::Driver::kRateHz;
  const Eigen::Vector2d position = sim_->T_GB().translation().head<2>();
  const double step = last_position_ ? (position - *last_position_).norm() : 0;
  last_position_ = position;
  report_.way_m += step;
  if (step > kMoving * dt) {
    (sees_ ? report_.seeing_s : report_.blind_s) += dt;
    (sees_ ? report_.seeing_way_m : report_.blind_way_m) += step;
  }
  const navigate::Driver::Output out = driver_->Update(sim_->now());
  sim_->Command({sim_->now(), ++commands_, out.speed.v, out.speed.w});
  for (const navigate::Event& event : out.events) {
    report_.reached += event.kind == navigate::EventKind::kReached ? 1 : 0;
    report_.blocked += event.kind == navigate::EventKind::kBlocked ? 1 : 0;
    report_.held += event.kind == navigate::EventKind::kHeld ? 1 : 0;
    if (on_event) on_event(event);
  }
}

void ClosedLoop::Run(const std::function<bool(double)>& goes_on) {
  int64_t ms = 0;
  bool stop = false;
  while (!stop && !driver_->finished() && sim_->Step()) {
    for (const Outgoing& message : sim_->Take()) Deliver(message);
    if (++ms % kControlEveryMs == 0) Control();
    if (ms % kGridEveryMs == 0) SendGrid();
    if (ms % 1000 == 0) stop = !goes_on(sim_->seconds());
  }
  slam_.Finish();
  grid_.Compose();
  report_.seconds = sim_->seconds();
  report_.stops = driver_->num_stops();
  report_.finished = driver_->finished();
}

}  // namespace gw::sim

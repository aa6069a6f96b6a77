#include "tools/lab/slam/slam_session.h"

#include <algorithm>
#include <utility>

#include "common/vision/scale_lengths.h"
#include "common/wire/channels.h"

namespace gw::tools {

SlamSession::SlamSession(const RobotConfig& config, const CameraGeometry& geometry, Stages stages,
                         BackendSchedule backend)
    : config_(config),
      geometry_(geometry),
      stages_(std::move(stages)),
      backend_(std::move(backend)),
      newest_before_(backend_.mapper().map().newest_keyframe()) {
  Deliver({backend_.mapper().Snapshot(std::nullopt)});
}

Result<SlamSession::Stages> SlamSession::MakeStages(const RobotConfig& config,
                                                    const CameraGeometry& geometry) {
  auto tracker = frontend::Tracker::Create(config.frontend, geometry);
  if (!tracker) return tracker.error();
  Stages stages{std::move(*tracker), std::nullopt};
  const bool has_sensors = config.calibration.imu.present || config.calibration.wheel.present;
  if (config.dr_ekf.source == DrSource::kSensors && has_sensors) {
    auto filter = dr_ekf::DrFilter::Create(config.dr_ekf, config.calibration);
    if (!filter) return filter.error();
    stages.dr_filter = std::move(*filter);
  }
  return stages;
}

Result<SlamSession> SlamSession::Create(const RobotConfig& config, MapStart start) {
  const auto geometry = MakeCameraGeometry(config.calibration);
  if (!geometry) return geometry.error();
  auto stages = MakeStages(config, *geometry);
  if (!stages) return stages.error();
  auto mapper = backend::Mapper::Create(config.backend, config.frontend, geometry->rectified,
                                        std::move(start.map), start.use);
  if (!mapper) return mapper.error();
  for (const Keyframe& keyframe : start.pending) mapper->Insert(keyframe);
  return SlamSession(
      config, *geometry, std::move(*stages),
      BackendSchedule(std::move(*mapper), Milliseconds(config.process.slam_backend_latency_ms)));
}

void SlamSession::BeginLap(DurationUs shift) {
  lap_shift_ = shift;
  reset_base_ = newest_reset_ + 1;
  dr_.Clear();
  stages_ = *MakeStages(config_, geometry_);  // Create has made the same
  Deliver({backend_.mapper().Snapshot(std::nullopt)});
}

void SlamSession::Process(const process::LogEvent& event) {
  if (event.channel == wire::kCamera) {
    auto camera = wire::ViewCamera(event.data);
    if (!camera) {
      ++counters_.undecodable;
      return;
    }
    camera->frame.utime = OnLap(camera->frame.utime);
    ProcessImage(camera->frame);
  } else if (event.channel == wire::kImu && stages_.dr_filter) {
    auto sample = wire::Decode<ImuSample>(event.data);
    if (!sample) {
      ++counters_.undecodable;
      return;
    }
    sample->utime = OnLap(sample->utime);
    Deliver(stages_.dr_filter->Push(*sample));
  } else if (event.channel == wire::kWheel && stages_.dr_filter) {
    auto sample = wire::Decode<WheelSample>(event.data);
    if (!sample) {
      ++counters_.undecodable;
      return;
    }
    sample->utime = OnLap(sample->utime);
    sample->utime_begin = OnLap(sample->utime_begin);
    Deliver(stages_.dr_filter->Push(*sample));
  } else if (event.channel == wire::kDr && !stages_.dr_filter) {
    auto state = wire::Decode<DrState>(event.data);
    if (!state) {
      ++counters_.undecodable;
      return;
    }
    dr_synthetic_ |= state->synthetic;
    state->utime = OnLap(state->utime);
    ProcessDr(std::move(*state));
  }
}

void SlamSession::ProcessDr(DrState state) {
  state.reset_counter += reset_base_;
  newest_reset_ = std::max(newest_reset_, state.reset_counter);
  dr_.Push(state);  // refuses what the tracker refuses, which is counted
  if (!stages_.tracker.Push(state)) ++counters_.dr_refused;
}

void SlamSession::ProcessImage(const CameraFrame& frame) {
  ++counters_.images;
  Deliver(backend_.AdvanceTo(frame.utime));
  for (const PlaceMatch& match : backend_.Answers(frame.utime)) stages_.tracker.Push(match);
  const int64_t begin_us = now_us_ ? now_us_() : 0;
  frontend::TrackerOutput out = stages_.tracker.Push(frame);
  const frontend::ViewFault fault = stages_.tracker.view_fault();
  if (fault != frontend::ViewFault::kNone) view_fault_ = fault;
  if (now_us_) tracking_us_.push_back(now_us_() - begin_us);
  if (watch_.image) watch_.image(frame, out.pose);
  if (out.keyframe) FollowLengths(out.keyframe->length_factor);
  frames_.push_back(out.pose);
  out.detail.features = {};
  details_.push_back(std::move(out.detail));
  dr_poses_.push_back(dr_.PoseAt(frame.utime));
  if (stages_.dr_filter) Deliver(stages_.dr_filter->Push(out.pose));
  if (out.query) backend_.Ask(*out.query, frame.utime);
  if (out.keyframe) Deliver(backend_.Insert(*out.keyframe, frame.utime));
}

// The images before were told in lengths that have proven to be wrong.
void SlamSession::FollowLengths(double length_factor) {
  const double by = length_factor / std::exchange(length_factor_, length_factor);
  if (by == 1) return;
  for (FramePose& frame : frames_) frame.T_KC = ScaleLength(by, frame.T_KC);
}

void SlamSession::Deliver(const std::vector<MapUpdate>& updates) {
  for (const MapUpdate& update : updates) {
    if (watch_.map) watch_.map(update);
    if (stages_.tracker.Push(update)) continue;
    ++counters_.map_gaps;
    stages_.tracker.Push(backend_.mapper().Snapshot(std::nullopt));
  }
}

void SlamSession::Deliver(const dr_ekf::DrFilter::Output& output) {
  dr_counters_ = output.counters;
  if (watch_dr_) watch_dr_(output);
  for (const DrState& state : output.states) {
    if (first_dr_ == Utime()) first_dr_ = state.utime;
    newest_dr_ = state.utime;
    ProcessDr(state);
  }
  for (const dr_ekf::DrDiagnosis diagnosis : output.found) {
    dr_found_.push_back({newest_dr_, diagnosis});
  }
}

void SlamSession::Finish() {
  Deliver(backend_.Finish());
}

SE3 SlamSession::FinalPose(const FramePose& frame) const {
  const backend::Map& map = backend_.mapper().map();
  KeyframeId keyframe = frame.reference_keyframe;
  SE3 T_KC = frame.T_KC;
  if (const auto removal = map.FindRemoval(keyframe)) {
    T_KC = removal->T_ParentC * T_KC;
    keyframe = removal->parent;
  }
  const backend::MapKeyframe* reference = map.FindKeyframe(keyframe);
  if (reference == nullptr) return frame.T_WB;
  return reference->frame.T_WC * T_KC * camera().T_BC.inverse();
}

}  // namespace gw::tools

#include "tools/slam/slam_session.h"

#include <utility>

#include "lcmtypes/wire/channels.h"

namespace gw::tools {
namespace {

// The newest DR state lags the image by up to a wheel message and its delay.
constexpr DurationUs kMaxDrExtrapolation = Milliseconds(60);

}  // namespace

SlamSession::SlamSession(frontend::Tracker tracker, BackendSchedule backend,
                         std::optional<dr_ekf::DrFilter> dr_filter, const RectifiedCamera& camera)
    : tracker_(std::move(tracker)),
      backend_(std::move(backend)),
      dr_filter_(std::move(dr_filter)),
      camera_(camera) {
  Deliver({backend_.mapper().Snapshot(std::nullopt)});
}

Result<SlamSession> SlamSession::Create(const RobotConfig& config) {
  auto geometry = MakeCameraGeometry(config.calibration);
  if (!geometry) return geometry.error();
  auto tracker = frontend::Tracker::Create(config.frontend, *geometry);
  if (!tracker) return tracker.error();
  auto mapper = backend::Mapper::Create(config.backend, config.frontend, geometry->rectified);
  if (!mapper) return mapper.error();
  std::optional<dr_ekf::DrFilter> dr_filter;
  const bool has_sensors = config.calibration.imu.present || config.calibration.wheel.present;
  if (config.dr_ekf.source == DrSource::kSensors && has_sensors) {
    auto filter = dr_ekf::DrFilter::Create(config.dr_ekf, config.calibration);
    if (!filter) return filter.error();
    dr_filter = std::move(*filter);
  }
  return SlamSession(
      std::move(*tracker),
      BackendSchedule(std::move(*mapper), Milliseconds(config.process.slam_backend_latency_ms)),
      std::move(dr_filter), geometry->rectified);
}

void SlamSession::Process(const process::LogEvent& event) {
  if (event.channel == wire::kCamera) {
    auto camera = wire::DecodeCamera({event.data.begin(), event.data.end()});
    if (!camera) {
      ++counters_.undecodable;
      return;
    }
    ProcessImage(camera->frame);
  } else if (event.channel == wire::kImu && dr_filter_) {
    const auto sample = wire::Decode<ImuSample>(event.data);
    sample ? Deliver(dr_filter_->Push(*sample)) : void(++counters_.undecodable);
  } else if (event.channel == wire::kWheel && dr_filter_) {
    const auto sample = wire::Decode<WheelSample>(event.data);
    sample ? Deliver(dr_filter_->Push(*sample)) : void(++counters_.undecodable);
  } else if (event.channel == wire::kDr && !dr_filter_) {
    const auto state = wire::Decode<DrState>(event.data);
    if (!state) {
      ++counters_.undecodable;
      return;
    }
    dr_synthetic_ |= state->synthetic;
    ProcessDr(*state);
  }
}

void SlamSession::ProcessDr(const DrState& state) {
  dr_.Push(state);  // refuses what the tracker refuses, which is counted
  if (!tracker_.Push(state)) ++counters_.dr_refused;
}

void SlamSession::ProcessImage(const CameraFrame& frame) {
  ++counters_.images;
  Deliver(backend_.AdvanceTo(frame.utime));
  const int64_t begin_us = now_us_ ? now_us_() : 0;
  frontend::TrackerOutput out = tracker_.Push(frame);
  if (now_us_) tracking_us_.push_back(now_us_() - begin_us);
  frames_.push_back(out.pose);
  dr_poses_.push_back(dr_.PoseAt(frame.utime, kMaxDrExtrapolation));
  const auto increment =
      dr_.Increment(frame.utime - kDrCovarianceSpan, frame.utime, kMaxDrExtrapolation);
  dr_covariances_.push_back(increment ? std::optional(increment->cov) : std::nullopt);
  if (out.keyframe) Deliver(backend_.Insert(*out.keyframe, frame.utime));
}

void SlamSession::Deliver(const std::vector<MapUpdate>& updates) {
  for (const MapUpdate& update : updates) {
    if (tracker_.Push(update)) continue;
    ++counters_.map_gaps;
    tracker_.Push(backend_.mapper().Snapshot(std::nullopt));
  }
}

void SlamSession::Deliver(const dr_ekf::DrFilter::Output& output) {
  dr_counters_ = output.counters;
  for (const DrState& state : output.states) ProcessDr(state);
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
  return reference->frame.T_WC * T_KC * camera_.T_BC.inverse();
}

}  // namespace gw::tools

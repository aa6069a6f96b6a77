#include "frontend/process/frontend_node.h"

#include <utility>

#include "common/camera/camera_model.h"
#include "common/wire/channels.h"
#include "common/wire/frame_detail.h"
#include "frontend/core/tracking/health_cause.h"

namespace gw::frontend {
namespace {

constexpr DurationUs kRequestInterval = Milliseconds(300);
constexpr DurationUs kSilence = Milliseconds(500);  // camera called silent
// The longest that updates of the map wait for an image: a few periods of the slowest camera.
constexpr DurationUs kImageWait = Milliseconds(200);

}  // namespace

Result<std::unique_ptr<process::Node>> FrontendNode::Create(const RobotConfig& config) {
  const auto geometry = MakeCameraGeometry(config.calibration);
  if (!geometry) return geometry.error();
  auto tracker = Tracker::Create(config.frontend, *geometry);
  if (!tracker) return tracker.error();
  return std::unique_ptr<process::Node>(new FrontendNode(std::move(*tracker)));
}

Result<Done> FrontendNode::Start(process::Shell& shell) {
  session_ = shell.Now().us;
  keyframes_.emplace(session_);
  updates_.emplace(session_);
  Result<Done> ok = shell.ListenRaw(wire::kCamera, [this, &shell](auto bytes, Utime received) {
    auto camera = wire::DecodeCamera({bytes.begin(), bytes.end()});
    if (!camera) {
      shell.CountUndecodable(wire::kCamera, camera.error());
      return;
    }
    images_.push_back({std::move(*camera), received});
    shell.health().NoteQueue(static_cast<int64_t>(images_.size()));
    if (images_.size() > kMaxImages) {
      images_.pop_front();
      shell.health().Count("CAMERA.dropped");
    }
  });
  if (!ok) return ok;
  ok = shell.Listen<DrState>(wire::kDr, [this, &shell](const DrState& state, Utime) {
    if (!tracker_.Push(state)) shell.health().Count("DR.not_newer");
  });
  if (!ok) return ok;
  ok = shell.Listen<Pose>(wire::kPose, [this](const Pose& pose, Utime) { tracker_.Push(pose); });
  if (!ok) return ok;
  ok = shell.Listen<PlaceMatch>(wire::kPlaceMatch,
                                [this](const PlaceMatch& match, Utime) { tracker_.Push(match); });
  if (!ok) return ok;
  ok = shell.Listen<wire::Ack>(wire::kKeyframeAck,
                               [this](const wire::Ack& ack, Utime) { keyframes_->HandleAck(ack); });
  if (!ok) return ok;
  return shell.ListenRaw(wire::kMapUpdate,
                         [this, &shell](auto bytes, Utime) { TakeMapUpdates(bytes, shell); });
}

void FrontendNode::TakeMapUpdates(std::span<const uint8_t> message, process::Shell& shell) {
  for (wire::Bytes& bytes : updates_->Accept(message)) waiting_updates_.push_back(std::move(bytes));
  if (const auto ack = updates_->MakeAck(shell.Now())) {
    shell.Publish(wire::kMapUpdateAck, wire::Encode(*ack));
  }
}

void FrontendNode::ApplyMapUpdates(process::Shell& shell) {
  for (const wire::Bytes& bytes : std::exchange(waiting_updates_, {})) {
    const auto update = wire::Decode<MapUpdate>(bytes);
    if (!update) {
      shell.CountUndecodable(wire::kMapUpdate, update.error());
      map_wanted_ = true;
      continue;
    }
    if (!tracker_.has_map() && !update->snapshot) continue;
    if (!tracker_.Push(*update)) {
      shell.health().Count("MAP_UPDATE.gaps");
      map_wanted_ = true;
    } else if (update->snapshot) {
      map_wanted_ = false;
    }
  }
}

void FrontendNode::RequestMap(process::Shell& shell) {
  const Utime now = shell.Now();
  if (last_request_ && now - *last_request_ < kRequestInterval) return;
  last_request_ = now;
  wire::Bytes message = wire::Encode(tracker_.Request());
  wire::SetDelivery({.seq = ++request_seq_, .session = session_, .oldest_seq = request_seq_},
                    message);
  shell.Publish(wire::kMapRequest, message);
}

void FrontendNode::ProcessImage(const WaitingImage& image, process::Shell& shell) {
  TrackerOutput out = tracker_.Push(image.camera.frame);
  const DurationUs latency = shell.Now() - image.received;
  out.pose.latency_us = latency.us;
  shell.Publish(wire::kFrameDetail, wire::Encode(out.detail));
  shell.Publish(wire::kFramePose, wire::Encode(out.pose));
  shell.health().AddLatency(latency);
  newest_ = out.pose;
  if (newest_.reason == TrackingReason::kTimeReversed) shell.health().Count("CAMERA.time_reversed");
  if (newest_.reason == TrackingReason::kDrContradictsVision)
    shell.health().Count("DR.contradicts_vision");
  if (newest_.reason == TrackingReason::kEyesApart) shell.health().Count("CAMERA.eyes_apart");
  if (newest_.reason == TrackingReason::kFixedInImage)
    shell.health().Count("CAMERA.fixed_in_image");
  last_image_ = shell.Now();
  if (out.query) {
    out.query->seq = ++query_seq_;
    shell.Publish(wire::kPlaceQuery, wire::Encode(*out.query));
  }
  if (out.keyframe) keyframes_->Push(wire::Encode(*out.keyframe));
}

void FrontendNode::ReportHealth(process::Shell& shell) const {
  using enum HealthState;
  if (!tracker_.has_map()) {
    shell.health().SetState(kStarting, "waiting for the map: is gw-backend running?");
  } else if (!last_image_ || shell.Now() - *last_image_ > kSilence) {
    shell.health().SetState(kDegraded, "no images: check gw-camera and its cable");
  } else if (const std::string cause = HealthCause(newest_, tracker_.dr_fault(),
                                                   tracker_.length_fault(), tracker_.view_fault());
             !cause.empty()) {
    shell.health().SetState(kDegraded, cause);
  } else {
    shell.health().SetState(kOk);
  }
}

bool FrontendNode::Step(process::Shell& shell) {
  if (!images_.empty()) {
    const WaitingImage image = std::move(images_.front());
    images_.pop_front();
    ProcessImage(image, shell);
    ApplyMapUpdates(shell);
  } else if (!last_image_ || shell.Now() - *last_image_ > kImageWait) {
    ApplyMapUpdates(shell);
  }
  if (map_wanted_) RequestMap(shell);
  for (const wire::Bytes* message : keyframes_->Due(shell.Now())) {
    shell.Publish(wire::kKeyframe, *message);
  }

  ReportHealth(shell);
  return images_.empty();
}

}  // namespace gw::frontend

#include "dr_ekf/core/pose_composer.h"

#include <algorithm>
#include <cmath>

#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {
namespace {

// How far the robot may have gone while dead reckoning was not there, at least.
constexpr double kResetWay = 0.1;   // m
constexpr double kResetTurn = 0.1;  // rad

// Than what T_OB makes of the last one.
bool IsBetterThanDeadReckoning(const FramePose& frame) {
  switch (frame.status) {
    case TrackingStatus::kTracking:
    case TrackingStatus::kDegraded:
    case TrackingStatus::kDrOnly:  // without the scale errors that vision has seen (ADR 11)
      return true;
    case TrackingStatus::kRecovering:
      // Found again, or doubted: then the covariance takes our claim back. A front-end that only
      // begins knows less than we do.
      return frame.reason != TrackingReason::kPlaceUnknown;
    case TrackingStatus::kInvalid:
    case TrackingStatus::kInitializing:
    case TrackingStatus::kLost:
      return false;
  }
  return false;
}

}  // namespace

void PoseComposer::Anchor(const SE3& T_WB, const Matrix6d& cov_T_WB, const SE3& T_OB) {
  T_WO_ = T_WB * T_OB.inverse();
  const Matrix6d adj = T_OB.Adjoint();
  cov_T_WO_ = adj * cov_T_WB * adj.transpose();
  cov_ = cov_T_WB;
  noise_ = DrNoise();
}

std::optional<Pose> PoseComposer::Push(const DrState& state) {
  if (!state.T_OB.IsFinite() || !state.cov_twist_white.allFinite() ||
      !state.cov_twist_coherent.allFinite() || !std::isfinite(state.way_scale_sigma) ||
      !std::isfinite(state.turn_scale_sigma)) {
    return std::nullopt;
  }
  if (newest_ && state.reset_counter != newest_->reset_counter) {
    // Nobody saw the motion across the reset: T_WB goes on where it was, with that much more doubt.
    const double gap_s = std::clamp((state.utime - newest_->utime).seconds(), 0.0, 60.0);
    const double way = kResetWay + kUnmeasuredSpeed * gap_s;
    const double turn = std::min(M_PI, kResetTurn + kUnmeasuredYawRate * gap_s);
    Vector6d doubt;
    doubt << way * way, way * way, 0, 0, 0, turn * turn;
    Anchor(last_pose_->T_WB, last_pose_->cov_T_WB + Matrix6d(doubt.asDiagonal()), state.T_OB);
    history_.Clear();
  } else if (newest_ && state.utime > newest_->utime) {
    const double dt = (state.utime - newest_->utime).seconds();
    const SE3 T_step = newest_->T_OB.inverse() * state.T_OB;
    const Matrix6d adj = T_step.inverse().Adjoint();
    cov_ = adj * cov_ * adj.transpose();
    noise_.Append(state, T_step, dt);
  }
  if (!history_.Push(state)) return std::nullopt;
  newest_ = state;

  Pose pose;
  pose.utime = state.utime;
  pose.seq = ++seq_;
  pose.T_WO = T_WO_;
  pose.cov_T_WO = cov_T_WO_;
  pose.T_WB = T_WO_ * state.T_OB;
  pose.cov_T_WB = cov_ + noise_.Covariance();
  pose.v_WB_B = state.v_OB_B;
  pose.w_WB_B = state.w_OB_B;
  pose.has_map = has_map_;
  pose.frame_pose_age_us = has_map_ ? (state.utime - frame_utime_).us : 0;
  pose.frame_pose_seq = frame_seq_;
  pose.map_revision = map_revision_;
  pose.dr_seq = state.seq;
  pose.dr_reset_counter = state.reset_counter;
  last_pose_ = pose;
  return pose;
}

LatchResult PoseComposer::Push(const FramePose& frame) {
  if (!frame.T_WB.IsFinite() || !frame.cov_T_WB.allFinite()) return LatchResult::kInvalid;
  if (!IsBetterThanDeadReckoning(frame)) return LatchResult::kIgnoredStatus;
  if (has_map_ && frame.utime <= frame_utime_) return LatchResult::kStale;
  const std::optional<SE3> T_OB = history_.PoseAt(frame.utime);
  if (!T_OB) return LatchResult::kNoDeadReckoning;

  Anchor(frame.T_WB, frame.cov_T_WB, *T_OB);
  if (frame.utime < newest_->utime) {
    const std::optional<DrIncrement> since =
        history_.Increment(frame.utime, newest_->utime, &noise_);
    if (since) {
      const Matrix6d adj = since->T_BaBb.inverse().Adjoint();
      cov_ = adj * cov_ * adj.transpose();
    }
  }
  has_map_ = true;
  frame_utime_ = frame.utime;
  frame_seq_ = frame.seq;
  map_revision_ = frame.map_revision;
  return LatchResult::kLatched;
}

}  // namespace gw::dr_ekf

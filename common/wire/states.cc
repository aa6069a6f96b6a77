// Messages that state where the robot is and how the processes are.
#include <gw_lcm/ack_t.hpp>
#include <gw_lcm/dr_t.hpp>
#include <gw_lcm/frame_pose_t.hpp>
#include <gw_lcm/health_t.hpp>
#include <gw_lcm/pose_t.hpp>

#include "common/wire/archive.h"

namespace gw::wire {
namespace {

constexpr int32_t kMaxCount = std::numeric_limits<int32_t>::max();
constexpr double kMaxReal = std::numeric_limits<double>::max();

using FramePoseType = gw_lcm::frame_pose_t;
constexpr auto kLastStatus = static_cast<int32_t>(TrackingStatus::kLost);
constexpr auto kLastReason = static_cast<int32_t>(TrackingReason::kEyesExchanged);
constexpr auto kLastHealth = static_cast<int32_t>(HealthState::kFailed);
static_assert(FramePoseType::STATUS_TRACKING == static_cast<int>(TrackingStatus::kTracking));
static_assert(FramePoseType::STATUS_DR_ONLY == static_cast<int>(TrackingStatus::kDrOnly));
static_assert(FramePoseType::STATUS_LOST == kLastStatus);
static_assert(FramePoseType::REASON_POSE_JUMP == static_cast<int>(TrackingReason::kPoseJump));
static_assert(FramePoseType::REASON_EYES_EXCHANGED == kLastReason);
static_assert(gw_lcm::health_t::STATE_OK == static_cast<int>(HealthState::kOk));
static_assert(gw_lcm::health_t::STATE_FAILED == kLastHealth);

}  // namespace

template <typename A>
static void Fields(A& a, typename A::template Of<DrState>& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  ResetCounter(a, "reset_counter", m.reset_counter);
  Transform(a, "T_OB", m.T_OB);
  Vector(a, "v_OB_B_m_s", m.v_OB_B);
  Vector(a, "w_OB_B_rad_s", m.w_OB_B);
  Vector(a, "gyro_bias_rad_s", m.gyro_bias_rad_s);
  Vector(a, "accel_bias_m_s2", m.accel_bias_m_s2);
  a.Real("wheel_scale", m.wheel_scale, 0, kMaxReal);
  a.Real("turn_scale", m.turn_scale, 0, kMaxReal);
  Covariance(a, "cov_T_OB_m2_rad2", m.cov_T_OB);
  Covariance(a, "cov_twist_white_m2_s_rad2_s", m.cov_twist_white);
  Covariance(a, "cov_twist_coherent_m2_s2_rad2_s2", m.cov_twist_coherent);
  a.Real("way_scale_sigma", m.way_scale_sigma, 0, kMaxReal);
  a.Real("turn_scale_sigma", m.turn_scale_sigma, 0, kMaxReal);
  a.Bool("gravity_aligned", m.gravity_aligned);
  a.Bool("slip", m.slip);
  a.Bool("stationary", m.stationary);
  a.Bool("wheels_alive", m.wheels_alive);
  a.Bool("imu_alive", m.imu_alive);
  a.Bool("synthetic", m.synthetic);
}

template <typename A>
static void Fields(A& a, typename A::template Of<FramePose>& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  Transform(a, "T_WB", m.T_WB);
  Covariance(a, "cov_T_WB_m2_rad2", m.cov_T_WB);
  a.Duration("motion_us", m.motion_us);
  Covariance(a, "cov_motion_m2_rad2", m.cov_motion);
  Enum(a, "status", m.status, kLastStatus);
  Enum(a, "reason", m.reason, kLastReason);
  a.Int32("num_detected", m.num_detected, 0, kMaxCount);
  a.Int32("num_tracked", m.num_tracked, 0, kMaxCount);
  a.Int32("num_inliers", m.num_inliers, 0, kMaxCount);
  a.Real("quality", m.q, 0, 1);
  a.Real("alpha", m.alpha, 0, kMaxReal);
  a.Real("dr_share", m.dr_share, 0, 1);
  Seq(a, "map_revision", m.map_revision);
  Id(a, "reference_keyframe_id", m.reference_keyframe, false);
  Transform(a, "T_KC", m.T_KC);
  Seq(a, "dr_seq", m.dr_seq);
  ResetCounter(a, "dr_reset_counter", m.dr_reset_counter);
  a.Duration("latency_us", m.latency_us);
}

template <typename A>
static void Fields(A& a, typename A::template Of<Pose>& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  Transform(a, "T_WB", m.T_WB);
  Covariance(a, "cov_T_WB_m2_rad2", m.cov_T_WB);
  Vector(a, "v_WB_B_m_s", m.v_WB_B);
  Vector(a, "w_WB_B_rad_s", m.w_WB_B);
  Transform(a, "T_WO", m.T_WO);
  Covariance(a, "cov_T_WO_m2_rad2", m.cov_T_WO);
  a.Bool("has_map", m.has_map);
  a.Duration("frame_pose_age_us", m.frame_pose_age_us);
  Seq(a, "frame_pose_seq", m.frame_pose_seq);
  Seq(a, "map_revision", m.map_revision);
  Seq(a, "dr_seq", m.dr_seq);
  ResetCounter(a, "dr_reset_counter", m.dr_reset_counter);
  ResetCounter(a, "reset_counter", m.reset_counter);
}

template <typename A>
static void Fields(A& a, typename A::template Of<Ack>& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  a.Duration("session", m.session);
  a.Duration("acked_session", m.acked_session);
  Seq(a, "acked_seq", m.acked_seq);
}

template <typename A>
static void Fields(A& a, typename A::template Of<Health>& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  a.Text("process", m.process);
  Enum(a, "state", m.state, kLastHealth);
  a.Text("message", m.message);
  a.List("counters", m.counters, kMaxCount, 13, [](A& each, auto& counter) {
    each.Text("counters.name", counter.first);
    each.Int64("counters.value", counter.second, std::numeric_limits<int64_t>::min(),
               std::numeric_limits<int64_t>::max());
  });
  a.Duration("latency_p50_us", m.latency_p50_us);
  a.Duration("latency_p99_us", m.latency_p99_us);
  a.Duration("latency_max_us", m.latency_max_us);
  Seq(a, "queue_peak", m.queue_peak);
  a.Bits64(m.config_hash);
  a.Text("version", m.version);
}

Bytes Encode(const DrState& state) {
  return EncodeFields(gw_lcm::dr_t::getHash(), state);
}
template <>
Result<DrState> Decode(ByteSpan message) {
  return DecodeFields<DrState>("dr_t", gw_lcm::dr_t::getHash(), message);
}

Bytes Encode(const FramePose& pose) {
  return EncodeFields(FramePoseType::getHash(), pose);
}
template <>
Result<FramePose> Decode(ByteSpan message) {
  return DecodeFields<FramePose>("frame_pose_t", FramePoseType::getHash(), message);
}

Bytes Encode(const Pose& pose) {
  return EncodeFields(gw_lcm::pose_t::getHash(), pose);
}
template <>
Result<Pose> Decode(ByteSpan message) {
  return DecodeFields<Pose>("pose_t", gw_lcm::pose_t::getHash(), message);
}

Bytes Encode(const Ack& ack) {
  return EncodeFields(gw_lcm::ack_t::getHash(), ack);
}
template <>
Result<Ack> Decode(ByteSpan message) {
  return DecodeFields<Ack>("ack_t", gw_lcm::ack_t::getHash(), message);
}

Bytes Encode(const Health& health) {
  return EncodeFields(gw_lcm::health_t::getHash(), health);
}
template <>
Result<Health> Decode(ByteSpan message) {
  return DecodeFields<Health>("health_t", gw_lcm::health_t::getHash(), message);
}

}  // namespace gw::wire

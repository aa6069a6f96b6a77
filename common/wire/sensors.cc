// Messages of the drivers, the simulator and the importer, except CAMERA.
#include <gw_lcm/base_command_t.hpp>
#include <gw_lcm/ground_truth_t.hpp>
#include <gw_lcm/imu_t.hpp>
#include <gw_lcm/note_t.hpp>
#include <gw_lcm/wheel_t.hpp>

#include "common/wire/archive.h"

namespace gw::wire {
template <typename A>
static void Fields(A& a, typename A::template Of<ImuSample>& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  Vector(a, "w_I_rad_s", m.w_I_rad_s);
  Vector(a, "a_I_m_s2", m.a_I_m_s2);
  a.Bool("has_accel", m.has_accel);
}

template <typename A>
static void Fields(A& a, typename A::template Of<WheelSample>& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  a.Time("utime_begin", m.utime_begin);
  a.Rule("utime_begin", "after utime", m.utime_begin <= m.utime);
  a.Bool("has_ticks", m.has_ticks);
  a.Int32("left_ticks", m.left_ticks, 0, 65535);
  a.Int32("right_ticks", m.right_ticks, 0, 65535);
  a.Real("dx_B_m", m.dx_m);
  a.Real("dy_B_m", m.dy_m);
  a.Real("dyaw_B_rad", m.dyaw_rad);
  a.Bool("has_heading", m.has_heading);
  a.Real("heading_rad", m.heading_rad);
  a.Bool("bumper", m.contact.bumper);
  a.Bool("cliff", m.contact.cliff);
  a.Bool("wheel_drop", m.contact.wheel_drop);
}

template <typename A>
static void Fields(A& a, typename A::template Of<GroundTruth>& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  Transform(a, "T_GB", m.T_GB);
}

template <typename A>
static void Fields(A& a, typename A::template Of<BaseCommand>& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  a.Real("command_v_m_s", m.v_m_s);
  a.Real("command_w_rad_s", m.w_rad_s);
}

template <typename A>
static void Fields(A& a, typename A::template Of<Note>& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  a.Text("key", m.key);
  a.Text("text", m.text);
}

Bytes Encode(const ImuSample& sample) {
  return EncodeFields(gw_lcm::imu_t::getHash(), sample);
}
template <>
Result<ImuSample> Decode(ByteSpan message) {
  return DecodeFields<ImuSample>("imu_t", gw_lcm::imu_t::getHash(), message);
}

Bytes Encode(const WheelSample& sample) {
  return EncodeFields(gw_lcm::wheel_t::getHash(), sample);
}
template <>
Result<WheelSample> Decode(ByteSpan message) {
  return DecodeFields<WheelSample>("wheel_t", gw_lcm::wheel_t::getHash(), message);
}

Bytes Encode(const GroundTruth& truth) {
  return EncodeFields(gw_lcm::ground_truth_t::getHash(), truth);
}
template <>
Result<GroundTruth> Decode(ByteSpan message) {
  return DecodeFields<GroundTruth>("ground_truth_t", gw_lcm::ground_truth_t::getHash(), message);
}

Bytes Encode(const BaseCommand& command) {
  return EncodeFields(gw_lcm::base_command_t::getHash(), command);
}
template <>
Result<BaseCommand> Decode(ByteSpan message) {
  return DecodeFields<BaseCommand>("base_command_t", gw_lcm::base_command_t::getHash(), message);
}

Bytes Encode(const Note& note) {
  return EncodeFields(gw_lcm::note_t::getHash(), note);
}
template <>
Result<Note> Decode(ByteSpan message) {
  return DecodeFields<Note>("note_t", gw_lcm::note_t::getHash(), message);
}

}  // namespace gw::wire

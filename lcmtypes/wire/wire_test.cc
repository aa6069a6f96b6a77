#include "lcmtypes/wire/wire.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gw_lcm/ack_t.hpp>
#include <gw_lcm/base_command_t.hpp>
#include <gw_lcm/camera_t.hpp>
#include <gw_lcm/dr_t.hpp>
#include <gw_lcm/frame_pose_t.hpp>
#include <gw_lcm/ground_truth_t.hpp>
#include <gw_lcm/health_t.hpp>
#include <gw_lcm/imu_t.hpp>
#include <gw_lcm/keyframe_t.hpp>
#include <gw_lcm/map_request_t.hpp>
#include <gw_lcm/map_update_t.hpp>
#include <gw_lcm/note_t.hpp>
#include <gw_lcm/place_match_t.hpp>
#include <gw_lcm/place_query_t.hpp>
#include <gw_lcm/pose_t.hpp>
#include <gw_lcm/wheel_t.hpp>
#include <limits>

#include "lcmtypes/wire/testing.h"

namespace gw::wire {
namespace {

using testing::RandomMessages;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

// What lcm-gen's own code makes of our bytes; it must take all of them.
template <typename Type>
Type Generated(const Bytes& bytes) {
  Type generated;
  EXPECT_EQ(generated.decode(bytes.data(), 0, static_cast<int>(bytes.size())),
            static_cast<int>(bytes.size()));
  return generated;
}
template <typename Type>
Bytes GeneratedBytes(const Type& generated) {
  Bytes bytes(generated.getEncodedSize());
  EXPECT_EQ(generated.encode(bytes.data(), 0, static_cast<int>(bytes.size())),
            static_cast<int>(bytes.size()));
  return bytes;
}

void ExpectSame(const double (&wire)[3], const Eigen::Vector3d& v) {
  for (int i = 0; i < 3; ++i) EXPECT_EQ(wire[i], v[i]);
}
void ExpectSame(const double (&p)[3], const double (&q_wxyz)[4], const SE3& T) {
  ExpectSame(p, T.translation());
  const auto& q = T.rotation();
  EXPECT_THAT(q_wxyz, ::testing::ElementsAre(q.w(), q.x(), q.y(), q.z()));
}
void ExpectSame(const double (&wire)[36], const Matrix6d& cov) {
  for (int i = 0; i < 36; ++i) EXPECT_EQ(wire[i], cov(i / 6, i % 6));
}
void ExpectSame(const uint8_t (&wire)[32], const Descriptor& descriptor) {
  for (int bit = 0; bit < 256; ++bit) {
    EXPECT_EQ(wire[bit / 8] >> (bit % 8) & 1, descriptor[bit / 64] >> (bit % 64) & 1);
  }
}

// Field by field, by name: the generated struct holds what the contract struct holds.
void ExpectSame(const gw_lcm::imu_t& g, const ImuSample& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  ExpectSame(g.w_I_rad_s, m.w_I_rad_s);
  ExpectSame(g.a_I_m_s2, m.a_I_m_s2);
  EXPECT_EQ(g.has_accel, m.has_accel);
}
void ExpectSame(const gw_lcm::wheel_t& g, const WheelSample& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  EXPECT_EQ(g.utime_begin, m.utime_begin.us);
  EXPECT_EQ(g.has_ticks, m.has_ticks);
  EXPECT_EQ(g.left_ticks, m.left_ticks);
  EXPECT_EQ(g.right_ticks, m.right_ticks);
  EXPECT_EQ(g.dx_B_m, m.dx_m);
  EXPECT_EQ(g.dy_B_m, m.dy_m);
  EXPECT_EQ(g.dyaw_B_rad, m.dyaw_rad);
  EXPECT_EQ(g.has_heading, m.has_heading);
  EXPECT_EQ(g.heading_rad, m.heading_rad);
  EXPECT_EQ(g.bumper, m.contact.bumper);
  EXPECT_EQ(g.cliff, m.contact.cliff);
  EXPECT_EQ(g.wheel_drop, m.contact.wheel_drop);
}
void ExpectSame(const gw_lcm::ground_truth_t& g, const GroundTruth& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  ExpectSame(g.p_GB_m, g.q_GB_wxyz, m.T_GB);
}
void ExpectSame(const gw_lcm::base_command_t& g, const BaseCommand& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  EXPECT_EQ(g.command_v_m_s, m.v_m_s);
  EXPECT_EQ(g.command_w_rad_s, m.w_rad_s);
}
void ExpectSame(const gw_lcm::note_t& g, const Note& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  EXPECT_EQ(g.key, m.key);
  EXPECT_EQ(g.text, m.text);
}
void ExpectSame(const gw_lcm::ack_t& g, const Ack& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  EXPECT_EQ(g.session, m.session);
  EXPECT_EQ(g.acked_session, m.acked_session);
  EXPECT_EQ(g.acked_seq, m.acked_seq);
}
void ExpectSame(const gw_lcm::dr_t& g, const DrState& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  EXPECT_EQ(g.reset_counter, m.reset_counter);
  ExpectSame(g.p_OB_m, g.q_OB_wxyz, m.T_OB);
  ExpectSame(g.v_OB_B_m_s, m.v_OB_B);
  ExpectSame(g.w_OB_B_rad_s, m.w_OB_B);
  ExpectSame(g.gyro_bias_rad_s, m.gyro_bias_rad_s);
  ExpectSame(g.accel_bias_m_s2, m.accel_bias_m_s2);
  EXPECT_EQ(g.wheel_scale, m.wheel_scale);
  EXPECT_EQ(g.turn_scale, m.turn_scale);
  ExpectSame(g.cov_T_OB_m2_rad2, m.cov_T_OB);
  ExpectSame(g.cov_twist_white_m2_s_rad2_s, m.cov_twist_white);
  ExpectSame(g.cov_twist_coherent_m2_s2_rad2_s2, m.cov_twist_coherent);
  EXPECT_EQ(g.way_scale_sigma, m.way_scale_sigma);
  EXPECT_EQ(g.turn_scale_sigma, m.turn_scale_sigma);
  EXPECT_EQ(g.gravity_aligned, m.gravity_aligned);
  EXPECT_EQ(g.slip, m.slip);
  EXPECT_EQ(g.stationary, m.stationary);
  EXPECT_EQ(g.wheels_alive, m.wheels_alive);
  EXPECT_EQ(g.imu_alive, m.imu_alive);
  EXPECT_EQ(g.synthetic, m.synthetic);
}
void ExpectSame(const gw_lcm::frame_pose_t& g, const FramePose& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  ExpectSame(g.p_WB_m, g.q_WB_wxyz, m.T_WB);
  ExpectSame(g.cov_T_WB_m2_rad2, m.cov_T_WB);
  EXPECT_EQ(g.motion_us, m.motion_us);
  ExpectSame(g.cov_motion_m2_rad2, m.cov_motion);
  EXPECT_EQ(g.status, static_cast<int>(m.status));
  EXPECT_EQ(g.reason, static_cast<int>(m.reason));
  EXPECT_EQ(g.num_detected, m.num_detected);
  EXPECT_EQ(g.num_tracked, m.num_tracked);
  EXPECT_EQ(g.num_inliers, m.num_inliers);
  EXPECT_EQ(g.quality, m.q);
  EXPECT_EQ(g.alpha, m.alpha);
  EXPECT_EQ(g.dr_share, m.dr_share);
  EXPECT_EQ(g.map_revision, m.map_revision);
  EXPECT_EQ(g.reference_keyframe_id, m.reference_keyframe.value);
  ExpectSame(g.p_KC_m, g.q_KC_wxyz, m.T_KC);
  EXPECT_EQ(g.dr_seq, m.dr_seq);
  EXPECT_EQ(g.dr_reset_counter, m.dr_reset_counter);
  EXPECT_EQ(g.latency_us, m.latency_us);
}
void ExpectSame(const gw_lcm::pose_t& g, const Pose& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  ExpectSame(g.p_WB_m, g.q_WB_wxyz, m.T_WB);
  ExpectSame(g.cov_T_WB_m2_rad2, m.cov_T_WB);
  ExpectSame(g.v_WB_B_m_s, m.v_WB_B);
  ExpectSame(g.w_WB_B_rad_s, m.w_WB_B);
  ExpectSame(g.p_WO_m, g.q_WO_wxyz, m.T_WO);
  ExpectSame(g.cov_T_WO_m2_rad2, m.cov_T_WO);
  EXPECT_EQ(g.has_map, m.has_map);
  EXPECT_EQ(g.frame_pose_age_us, m.frame_pose_age_us);
  EXPECT_EQ(g.frame_pose_seq, m.frame_pose_seq);
  EXPECT_EQ(g.map_revision, m.map_revision);
  EXPECT_EQ(g.dr_seq, m.dr_seq);
  EXPECT_EQ(g.dr_reset_counter, m.dr_reset_counter);
}
void ExpectSame(const gw_lcm::health_t& g, const Health& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  EXPECT_EQ(g.process, m.process);
  EXPECT_EQ(g.state, static_cast<int>(m.state));
  EXPECT_EQ(g.message, m.message);
  ASSERT_EQ(g.counters.size(), m.counters.size());
  for (size_t i = 0; i < m.counters.size(); ++i) {
    EXPECT_EQ(g.counters[i].name, m.counters[i].first);
    EXPECT_EQ(g.counters[i].value, m.counters[i].second);
  }
  EXPECT_EQ(g.latency_p50_us, m.latency_p50_us);
  EXPECT_EQ(g.latency_p99_us, m.latency_p99_us);
  EXPECT_EQ(g.latency_max_us, m.latency_max_us);
  EXPECT_EQ(g.queue_peak, m.queue_peak);
  EXPECT_EQ(static_cast<uint64_t>(g.config_hash), m.config_hash);
  EXPECT_EQ(g.version, m.version);
}
void ExpectSame(const gw_lcm::keyframe_t& g, const Keyframe& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.keyframe_id, m.id.value);
  ExpectSame(g.p_WC_m, g.q_WC_wxyz, m.T_WC);
  ExpectSame(g.cov_T_WC_m2_rad2, m.cov_T_WC);
  EXPECT_EQ(g.map_revision, m.map_revision);
  EXPECT_EQ(g.previous_keyframe_id, m.previous.value);
  EXPECT_EQ(g.has_dr, m.dr.has_value());
  if (m.dr) {
    EXPECT_EQ(g.dr.utime_begin, m.dr->utime_begin.us);
    EXPECT_EQ(g.dr.utime_end, m.dr->utime_end.us);
    ExpectSame(g.dr.p_BaBb_Ba_m, g.dr.q_BaBb_wxyz, m.dr->T_BaBb);
    ExpectSame(g.dr.cov_T_BaBb_m2_rad2, m.dr->cov);
    EXPECT_EQ(g.dr.reset_counter, m.dr->reset_counter);
    EXPECT_EQ(g.dr.slip, m.dr->slip);
    EXPECT_EQ(g.dr.synthetic, m.dr->synthetic);
  }
  EXPECT_EQ(g.quality, m.q);
  EXPECT_EQ(g.num_tracked, m.num_tracked);
  ASSERT_EQ(g.features.size(), m.features.size());
  for (size_t i = 0; i < m.features.size(); ++i) {
    EXPECT_EQ(g.features[i].u_px, m.features[i].u);
    EXPECT_EQ(g.features[i].v_px, m.features[i].v);
    EXPECT_EQ(g.features[i].u_right_px, m.features[i].u_right);
    EXPECT_EQ(g.features[i].depth_m, m.features[i].depth);
    EXPECT_EQ(g.features[i].angle_rad, m.features[i].angle);
    EXPECT_EQ(g.features[i].level, m.features[i].level);
    ExpectSame(g.features[i].descriptor, m.descriptors[i]);
    EXPECT_EQ(g.features[i].landmark_id, m.landmarks[i].value);
  }
}
void ExpectSame(const gw_lcm::place_query_t& g, const PlaceQuery& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  ASSERT_EQ(g.features.size(), m.features.size());
  for (size_t i = 0; i < m.features.size(); ++i) {
    EXPECT_EQ(g.features[i].u_px, m.features[i].u);
    EXPECT_EQ(g.features[i].depth_m, m.features[i].depth);
    ExpectSame(g.features[i].descriptor, m.descriptors[i]);
    EXPECT_EQ(g.features[i].landmark_id, 0);
  }
}
void ExpectSame(const gw_lcm::place_match_t& g, const PlaceMatch& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  EXPECT_EQ(g.query_seq, m.query_seq);
  EXPECT_EQ(g.found, m.found);
  ExpectSame(g.p_WC_m, g.q_WC_wxyz, m.T_WC);
  ExpectSame(g.cov_T_WC_m2_rad2, m.cov_T_WC);
  EXPECT_EQ(g.num_sights, m.num_sights);
  EXPECT_EQ(g.map_revision, m.map_revision);
  EXPECT_EQ(g.keyframe_id, m.keyframe.value);
}
void ExpectSame(const gw_lcm::map_update_t& g, const MapUpdate& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  EXPECT_EQ(g.revision, m.revision);
  EXPECT_EQ(g.base_revision, m.base_revision);
  EXPECT_EQ(g.snapshot, m.snapshot);
  EXPECT_EQ(g.frozen, m.frozen);
  EXPECT_EQ(g.newest_keyframe_id, m.newest_keyframe.value);
  ASSERT_EQ(g.keyframes.size(), m.keyframes.size());
  for (size_t i = 0; i < m.keyframes.size(); ++i) {
    EXPECT_EQ(g.keyframes[i].keyframe_id, m.keyframes[i].id.value);
    EXPECT_EQ(g.keyframes[i].keyframe_utime, m.keyframes[i].utime.us);
    ExpectSame(g.keyframes[i].p_WC_m, g.keyframes[i].q_WC_wxyz, m.keyframes[i].T_WC);
  }
  ASSERT_EQ(g.removed_keyframes.size(), m.removed_keyframes.size());
  for (size_t i = 0; i < m.removed_keyframes.size(); ++i) {
    const auto& wire = g.removed_keyframes[i];
    EXPECT_EQ(wire.removed_keyframe_id, m.removed_keyframes[i].id.value);
    EXPECT_EQ(wire.parent_keyframe_id, m.removed_keyframes[i].parent.value);
    ExpectSame(wire.p_ParentC_m, wire.q_ParentC_wxyz, m.removed_keyframes[i].T_ParentC);
  }
  ASSERT_EQ(g.landmarks.size(), m.landmarks.size());
  for (size_t i = 0; i < m.landmarks.size(); ++i) {
    const auto& wire = g.landmarks[i];
    EXPECT_EQ(wire.landmark_id, m.landmarks[i].id.value);
    ExpectSame(wire.p_W_m, m.landmarks[i].p_W);
    ExpectSame(wire.normal_W, m.landmarks[i].normal_W);
    EXPECT_EQ(wire.min_distance_m, m.landmarks[i].min_distance);
    EXPECT_EQ(wire.max_distance_m, m.landmarks[i].max_distance);
    ExpectSame(wire.descriptor, m.landmarks[i].descriptor);
    ASSERT_EQ(wire.observations.size(), m.landmarks[i].observations.size());
    for (size_t k = 0; k < wire.observations.size(); ++k) {
      EXPECT_EQ(wire.observations[k].keyframe_id, m.landmarks[i].observations[k].keyframe.value);
      EXPECT_EQ(wire.observations[k].feature_index, m.landmarks[i].observations[k].feature_index);
    }
  }
  ASSERT_EQ(g.merged_landmarks.size(), m.merged_landmarks.size());
  for (size_t i = 0; i < m.merged_landmarks.size(); ++i) {
    EXPECT_EQ(g.merged_landmarks[i].from_landmark_id, m.merged_landmarks[i].from.value);
    EXPECT_EQ(g.merged_landmarks[i].into_landmark_id, m.merged_landmarks[i].into.value);
  }
  ASSERT_EQ(g.removed_landmark_ids.size(), m.removed_landmarks.size());
  for (size_t i = 0; i < m.removed_landmarks.size(); ++i) {
    EXPECT_EQ(g.removed_landmark_ids[i], m.removed_landmarks[i].value);
  }
  ASSERT_EQ(g.dr_edges.size(), m.dr_edges.size());
  for (size_t i = 0; i < m.dr_edges.size(); ++i) {
    EXPECT_EQ(g.dr_edges[i].from_keyframe_id, m.dr_edges[i].from.value);
    EXPECT_EQ(g.dr_edges[i].to_keyframe_id, m.dr_edges[i].to.value);
    EXPECT_EQ(g.dr_edges[i].alpha, m.dr_edges[i].alpha);
  }
  ASSERT_EQ(g.loops.size(), m.loops.size());
  for (size_t i = 0; i < m.loops.size(); ++i) {
    EXPECT_EQ(g.loops[i].loop_from_keyframe_id, m.loops[i].from.value);
    EXPECT_EQ(g.loops[i].loop_to_keyframe_id, m.loops[i].to.value);
    EXPECT_EQ(g.loops[i].accepted, m.loops[i].accepted);
    ExpectSame(g.loops[i].p_correction_m, g.loops[i].q_correction_wxyz, m.loops[i].T_correction);
  }
}
void ExpectSame(const gw_lcm::map_request_t& g, const MapRequest& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  EXPECT_EQ(g.has_guess, m.has_guess);
  ExpectSame(g.p_WC_guess_m, g.q_WC_guess_wxyz, m.T_WC_guess);
}

template <typename C, typename G>
struct Pair {
  using Contract = C;
  using Type = G;
};
template <typename P>
class Wire : public ::testing::Test {};
using AllTypes = ::testing::Types<
    Pair<ImuSample, gw_lcm::imu_t>, Pair<WheelSample, gw_lcm::wheel_t>,
    Pair<GroundTruth, gw_lcm::ground_truth_t>, Pair<BaseCommand, gw_lcm::base_command_t>,
    Pair<Note, gw_lcm::note_t>, Pair<Ack, gw_lcm::ack_t>, Pair<DrState, gw_lcm::dr_t>,
    Pair<FramePose, gw_lcm::frame_pose_t>, Pair<Pose, gw_lcm::pose_t>,
    Pair<Health, gw_lcm::health_t>, Pair<Keyframe, gw_lcm::keyframe_t>,
    Pair<MapUpdate, gw_lcm::map_update_t>, Pair<MapRequest, gw_lcm::map_request_t>,
    Pair<PlaceQuery, gw_lcm::place_query_t>, Pair<PlaceMatch, gw_lcm::place_match_t>>;
TYPED_TEST_SUITE(Wire, AllTypes);

TYPED_TEST(Wire, EncodesWhatLcmGenEncodes) {
  for (uint64_t seed = 0; seed < 100; ++seed) {
    const auto message = RandomMessages(seed).Make<typename TypeParam::Contract>();
    const Bytes bytes = Encode(message);
    const auto generated = Generated<typename TypeParam::Type>(bytes);
    ExpectSame(generated, message);
    EXPECT_EQ(GeneratedBytes(generated), bytes);
  }
}

TYPED_TEST(Wire, DecodeGivesBackEveryBit) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    const Bytes bytes = Encode(RandomMessages(seed).Make<typename TypeParam::Contract>());
    const auto decoded = Decode<typename TypeParam::Contract>(bytes);
    ASSERT_TRUE(decoded.ok()) << decoded.error().message;
    EXPECT_EQ(Encode(*decoded), bytes) << seed;
  }
}

TYPED_TEST(Wire, BeginsWithTimeAndSequence) {
  typename TypeParam::Contract message{};
  RandomMessages(1).Fill(message);
  const auto header = ReadHeader(Encode(message));
  ASSERT_TRUE(header);
  EXPECT_EQ(header->fingerprint, TypeParam::Type::getHash());
  EXPECT_EQ(header->utime, message.utime);
}

TYPED_TEST(Wire, RefusesEveryOtherLength) {
  Bytes bytes = Encode(RandomMessages(2).Make<typename TypeParam::Contract>());
  for (size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_FALSE(Decode<typename TypeParam::Contract>(ByteSpan(bytes).first(length)).ok());
  }
  bytes.push_back(0);
  EXPECT_FALSE(Decode<typename TypeParam::Contract>(bytes).ok());
}

TYPED_TEST(Wire, RefusesOtherTypes) {
  const auto expect_refused = [](const Bytes& bytes) {
    const auto decoded = Decode<typename TypeParam::Contract>(bytes);
    EXPECT_FALSE(decoded.ok());
    if (decoded.ok()) return;
    EXPECT_EQ(decoded.error().code, ErrorCode::kBadData);
    EXPECT_THAT(decoded.error().message, ::testing::HasSubstr("fingerprint"));
  };
  Bytes bytes = Encode(RandomMessages(3).Make<typename TypeParam::Contract>());
  bytes[7] ^= 1;
  expect_refused(bytes);
}

// Whatever happens to the bytes, the answer is a value that encodes again, or an error.
TYPED_TEST(Wire, NoDamageCrashes) {
  for (uint64_t seed = 0; seed < 2000; ++seed) {
    Bytes bytes = Encode(RandomMessages(seed).Make<typename TypeParam::Contract>());
    CounterRng rng(seed, 1, 0);
    for (uint32_t flips = 1 + rng.Below(8); flips > 0; --flips) {
      // The fingerprint stays, so that the fields are reached.
      const uint32_t at = 8 + rng.Below(static_cast<uint32_t>(bytes.size()) - 8);
      bytes[at] = static_cast<uint8_t>(rng.Below(3) == 0 ? 0xFF : rng.Below(256));
    }
    if (rng.Below(4) == 0) bytes.resize(rng.Below(static_cast<uint32_t>(bytes.size())));
    const auto decoded = Decode<typename TypeParam::Contract>(bytes);
    if (!decoded.ok()) continue;
    EXPECT_TRUE(Decode<typename TypeParam::Contract>(Encode(*decoded)).ok());
  }
}

// Refusals, one per rule. Each case breaks one thing of a valid generated struct.
template <typename Contract, typename Type>
void ExpectRefused(const Type& broken, const std::string& field) {
  const auto decoded = Decode<Contract>(GeneratedBytes(broken));
  ASSERT_FALSE(decoded.ok()) << field;
  EXPECT_EQ(decoded.error().code, ErrorCode::kBadData);
  EXPECT_THAT(decoded.error().message, ::testing::HasSubstr(": " + field + " is "));
}
bool HasElements(const Keyframe& m) {
  return !m.features.empty();
}
bool HasElements(const MapUpdate& m) {
  return !m.keyframes.empty() && !m.landmarks.empty();
}
template <typename T>
bool HasElements(const T&) {
  return true;
}
template <typename Contract, typename Type>
Type Valid() {
  Contract message;
  uint64_t seed = 0;
  do {
    message = RandomMessages(++seed).Make<Contract>();
  } while (!HasElements(message));
  return Generated<Type>(Encode(message));
}
#define EXPECT_REFUSED(Contract, Type, field, change) \
  do {                                                \
    auto m = Valid<Contract, gw_lcm::Type>();         \
    change;                                           \
    ExpectRefused<Contract>(m, field);                \
  } while (false)

TEST(WireRules, NumbersAreFinite) {
  for (const double bad : {kNan, kInf, -kInf}) {
    EXPECT_REFUSED(ImuSample, imu_t, "w_I_rad_s", m.w_I_rad_s[1] = bad);
    EXPECT_REFUSED(ImuSample, imu_t, "a_I_m_s2", m.a_I_m_s2[2] = bad);
    EXPECT_REFUSED(WheelSample, wheel_t, "dx_B_m", m.dx_B_m = bad);
    EXPECT_REFUSED(WheelSample, wheel_t, "heading_rad", m.heading_rad = bad);
    EXPECT_REFUSED(DrState, dr_t, "T_OB", m.p_OB_m[0] = bad);
    EXPECT_REFUSED(DrState, dr_t, "cov_T_OB_m2_rad2", m.cov_T_OB_m2_rad2[35] = bad);
    EXPECT_REFUSED(DrState, dr_t, "wheel_scale", m.wheel_scale = bad);
    EXPECT_REFUSED(FramePose, frame_pose_t, "alpha", m.alpha = bad);
    EXPECT_REFUSED(Pose, pose_t, "cov_T_WO_m2_rad2", m.cov_T_WO_m2_rad2[7] = bad);
    EXPECT_REFUSED(BaseCommand, base_command_t, "command_v_m_s", m.command_v_m_s = bad);
    EXPECT_REFUSED(Keyframe, keyframe_t, "features.u_px", m.features[0].u_px = float(bad));
    EXPECT_REFUSED(Keyframe, keyframe_t, "features.depth_m", m.features[0].depth_m = float(bad));
    EXPECT_REFUSED(MapUpdate, map_update_t, "landmarks.p_W_m", m.landmarks[0].p_W_m[1] = bad);
  }
}

TEST(WireRules, QuaternionsAreOfUnitLengthWithinOneThousandth) {
  const auto scale = [](double(&q)[4], double factor) {
    for (double& x : q) x *= factor;
  };
  for (const double factor : {0.0, 0.99, 1.002, -0.5, 1e200}) {
    EXPECT_REFUSED(GroundTruth, ground_truth_t, "T_GB", scale(m.q_GB_wxyz, factor));
    EXPECT_REFUSED(MapRequest, map_request_t, "T_WC_guess", scale(m.q_WC_guess_wxyz, factor));
    EXPECT_REFUSED(MapUpdate, map_update_t, "keyframes.T_WC",
                   scale(m.keyframes[0].q_WC_wxyz, factor));
  }
  auto m = Valid<GroundTruth, gw_lcm::ground_truth_t>();
  scale(m.q_GB_wxyz, 1.0009);
  const auto decoded = Decode<GroundTruth>(GeneratedBytes(m));
  ASSERT_TRUE(decoded.ok());
  EXPECT_NEAR(decoded->T_GB.rotation().norm(), 1.0, 1e-15);
}

TEST(WireRules, EnumsCountsAndSharesAreInRange) {
  for (const int bad : {-1, 7, 1 << 30}) {
    EXPECT_REFUSED(FramePose, frame_pose_t, "status", m.status = bad);
  }
  EXPECT_REFUSED(FramePose, frame_pose_t, "reason", m.reason = 9);
  EXPECT_REFUSED(Health, health_t, "state", m.state = 5);
  EXPECT_REFUSED(FramePose, frame_pose_t, "num_inliers", m.num_inliers = -1);
  EXPECT_REFUSED(FramePose, frame_pose_t, "quality", m.quality = 1.01);
  EXPECT_REFUSED(FramePose, frame_pose_t, "dr_share", m.dr_share = -0.01);
  EXPECT_REFUSED(FramePose, frame_pose_t, "alpha", m.alpha = -1);
  EXPECT_REFUSED(WheelSample, wheel_t, "left_ticks", m.left_ticks = 65536);
  EXPECT_REFUSED(WheelSample, wheel_t, "right_ticks", m.right_ticks = -1);
  EXPECT_REFUSED(DrState, dr_t, "reset_counter", m.reset_counter = int64_t{1} << 32);
  EXPECT_REFUSED(ImuSample, imu_t, "has_accel", m.has_accel = 2);
  EXPECT_REFUSED(Keyframe, keyframe_t, "features.level", m.features[0].level = 32);
}

TEST(WireRules, TimesIdsAndSequencesCannotOverflowArithmetic) {
  constexpr int64_t kMin = std::numeric_limits<int64_t>::min();
  constexpr int64_t kMax = std::numeric_limits<int64_t>::max();
  EXPECT_REFUSED(ImuSample, imu_t, "utime", m.utime = kMin);
  EXPECT_REFUSED(ImuSample, imu_t, "utime", m.utime = kMax);
  EXPECT_REFUSED(ImuSample, imu_t, "seq", m.seq = -1);
  EXPECT_REFUSED(Keyframe, keyframe_t, "keyframe_id", m.keyframe_id = 0);
  EXPECT_REFUSED(Keyframe, keyframe_t, "keyframe_id", m.keyframe_id = kMax);
  EXPECT_REFUSED(Keyframe, keyframe_t, "previous_keyframe_id", m.previous_keyframe_id = -1);
  EXPECT_REFUSED(Keyframe, keyframe_t, "features.landmark_id", m.features[0].landmark_id = kMax);
  EXPECT_REFUSED(MapUpdate, map_update_t, "landmarks.landmark_id", m.landmarks[0].landmark_id = 0);
  EXPECT_REFUSED(Pose, pose_t, "frame_pose_age_us", m.frame_pose_age_us = kMax);
}

TEST(WireRules, IntervalsAndRevisionsAreInOrder) {
  EXPECT_REFUSED(WheelSample, wheel_t, "utime_begin", m.utime_begin = m.utime + 1);
  EXPECT_REFUSED(Keyframe, keyframe_t, "dr.utime_begin", m.dr.utime_begin = m.dr.utime_end + 1);
  EXPECT_REFUSED(MapUpdate, map_update_t, "base_revision", m.base_revision = m.revision + 1);
  EXPECT_REFUSED(MapUpdate, map_update_t, "base_revision", (m.snapshot = 1, m.base_revision = 1));
}

TEST(WireRules, ObservationsAreSortedAndUnique) {
  const auto set = [](auto& landmark, std::vector<std::pair<int64_t, int>> list) {
    landmark.observations.clear();
    for (const auto& [keyframe, feature] : list) {
      landmark.observations.push_back({});
      landmark.observations.back().keyframe_id = keyframe;
      landmark.observations.back().feature_index = feature;
    }
    landmark.num_observations = static_cast<int32_t>(list.size());
  };
  const std::string field = "landmarks.observations";
  EXPECT_REFUSED(MapUpdate, map_update_t, field, set(m.landmarks[0], {{2, 5}, {1, 5}}));
  EXPECT_REFUSED(MapUpdate, map_update_t, field, set(m.landmarks[0], {{2, 5}, {2, 5}}));
  EXPECT_REFUSED(MapUpdate, map_update_t, field + ".feature_index",
                 set(m.landmarks[0], {{2, 1 << 14}}));
  EXPECT_REFUSED(MapUpdate, map_update_t, field + ".keyframe_id", set(m.landmarks[0], {{0, 1}}));
}

TEST(WireRules, ACountBeyondTheMessageAllocatesNothing) {
  Bytes bytes = Encode(MapUpdate{});  // seven counts of zero at the end
  for (int i = 0; i < 7; ++i) {
    for (const uint8_t high : {0x00, 0x7F, 0xFF}) {
      Bytes broken = bytes;
      uint8_t* count = broken.data() + broken.size() - 4 * (7 - i);
      count[0] = high;
      count[1] = 0xFF;
      const auto decoded = Decode<MapUpdate>(broken);
      ASSERT_FALSE(decoded.ok());
    }
  }
}

TEST(WireRules, TextsEndWithTheirOnlyNul) {
  const Bytes bytes = Encode(Note{{1}, 2, "key", "text"});
  Bytes unterminated = bytes;
  unterminated.back() = 'x';
  EXPECT_FALSE(Decode<Note>(unterminated).ok());
  Bytes broken = bytes;
  broken[broken.size() - 3] = 0;
  EXPECT_FALSE(Decode<Note>(broken).ok());
  Note with_nul{{1}, 2, std::string("a\0b", 3), ""};
  EXPECT_EQ(Decode<Note>(Encode(with_nul))->key, "a");  // LCM's strings cannot carry it
}

// CAMERA

void ExpectSamePixels(const ImageView& a, const ImageView& b) {
  ASSERT_EQ(a.empty(), b.empty());
  if (a.empty()) return;
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.format, b.format);
  for (int row = 0; row < a.height; ++row) {
    EXPECT_EQ(std::memcmp(a.data + row * a.stride, b.data + row * b.stride,
                          static_cast<size_t>(a.width) * BytesPerPixel(a.format)),
              0);
  }
}

TEST(WireCamera, RoundTripKeepsEveryPixel) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    Bytes pixels;
    const CameraFrame frame = RandomMessages(seed).Camera(pixels);
    const Bytes bytes = Encode(frame);
    const auto generated = Generated<gw_lcm::camera_t>(bytes);
    EXPECT_EQ(GeneratedBytes(generated), bytes);
    EXPECT_EQ(generated.num_images, 2);
    EXPECT_EQ(generated.images[0].kind, gw_lcm::camera_image_t::KIND_LEFT);
    const auto decoded = Decode<DecodedCamera>(bytes);
    ASSERT_TRUE(decoded.ok()) << decoded.error().message;
    EXPECT_EQ(decoded->frame.utime, frame.utime);
    EXPECT_EQ(decoded->frame.seq, frame.seq);
    EXPECT_EQ(decoded->frame.exposure_us, frame.exposure_us);
    EXPECT_EQ(decoded->frame.emitter, frame.emitter);
    ExpectSamePixels(decoded->frame.left, frame.left);
    ExpectSamePixels(decoded->frame.right, frame.right);
    ExpectSamePixels(decoded->frame.depth, frame.depth);
    EXPECT_EQ(reinterpret_cast<uintptr_t>(decoded->frame.depth.data) % 2, 0u) << seed;
    EXPECT_EQ(Encode(decoded->frame), bytes);
  }
}

TEST(WireCamera, TakesTheMessageOverWithoutCopying) {
  Bytes pixels;
  Bytes bytes = Encode(RandomMessages(1).Camera(pixels));
  const uint8_t* begin = bytes.data();
  const uint8_t* end = begin + bytes.size();
  auto decoded = DecodeCamera(std::move(bytes));
  ASSERT_TRUE(decoded.ok());
  const DecodedCamera kept = std::move(*decoded);
  EXPECT_GT(kept.frame.left.data, begin);
  EXPECT_LT(kept.frame.left.data, end);
}

TEST(WireCamera, RefusesImplausibleImages) {
  const auto frame = [] {
    gw_lcm::camera_t m{};
    m.num_images = 2;
    m.images.resize(2);
    m.images[0] = {1, 4, 3, 5, 1, 15, Bytes(15)};
    m.images[1] = {3, 4, 3, 8, 2, 24, Bytes(24)};
    return m;
  };
  ASSERT_TRUE(Decode<DecodedCamera>(GeneratedBytes(frame())).ok());
  const auto refused = [&](const std::string& field, auto change) {
    auto m = frame();
    change(m);
    ExpectRefused<DecodedCamera>(m, field);
  };
  refused("emitter", [](auto& m) { m.emitter = 3; });
  refused("exposure_us", [](auto& m) { m.exposure_us = -1; });
  refused("num_images", [](auto& m) {
    m.num_images = 0;
    m.images.clear();
  });
  refused("images.kind", [](auto& m) { m.images[0].kind = 4; });
  refused("images.kind", [](auto& m) { m.images[1] = m.images[0]; });
  refused("images", [](auto& m) {
    m.images.erase(m.images.begin());
    m.num_images = 1;
  });
  refused("images", [](auto& m) { m.images[1].width = 3; });
  for (const int bad : {0, -1, 8193, std::numeric_limits<int>::max()}) {
    refused("images.width", [bad](auto& m) { m.images[0].width = bad; });
    refused("images.height", [bad](auto& m) { m.images[0].height = bad; });
  }
  refused("images.row_stride", [](auto& m) { m.images[1].row_stride = 7; });
  refused("images.row_stride", [](auto& m) { m.images[0].row_stride = 1 << 20; });
  refused("images.row_stride", [](auto& m) {
    m.images[1].row_stride = 9;
    m.images[1].data.resize(m.images[1].size = 27);
  });
  refused("images.pixel_format", [](auto& m) { m.images[0].pixel_format = 0; });
  refused("images.pixel_format", [](auto& m) {
    m.images[0].pixel_format = 2;
    m.images[0].row_stride = 8;
    m.images[0].data.resize(m.images[0].size = 24);
  });
  refused("images.size", [](auto& m) { m.images[0].data.resize(m.images[0].size = 14); });
  refused("images.size", [](auto& m) { m.images[0].data.resize(m.images[0].size = 16); });
}

TEST(WireCamera, NoDamageCrashes) {
  for (uint64_t seed = 0; seed < 3000; ++seed) {
    Bytes pixels;
    Bytes bytes = Encode(RandomMessages(seed).Camera(pixels));
    CounterRng rng(seed, 1, 0);
    for (uint32_t flips = 1 + rng.Below(4); flips > 0; --flips) {
      bytes[8 + rng.Below(52)] = static_cast<uint8_t>(rng.Below(256));
    }
    if (rng.Below(4) == 0) bytes.resize(rng.Below(static_cast<uint32_t>(bytes.size())));
    const auto decoded = DecodeCamera(std::move(bytes));
    if (!decoded.ok()) continue;
    EXPECT_TRUE(Decode<DecodedCamera>(Encode(decoded->frame)).ok());
  }
}

// Delivery

TEST(WireDelivery, IsStampedIntoTheThreeTypesInPlace) {
  const Delivery delivery{42, 1'600'000'000'000'000, 40};
  Bytes keyframe = Encode(RandomMessages(1).Make<Keyframe>());
  Bytes update = Encode(RandomMessages(2).Make<MapUpdate>());
  Bytes request = Encode(RandomMessages(3).Make<MapRequest>());
  for (Bytes* message : {&keyframe, &update, &request}) {
    SetDelivery(delivery, *message);
    EXPECT_EQ(ReadDelivery(*message), delivery);
    EXPECT_EQ(ReadHeader(*message)->seq, 42);
  }
  const auto generated = Generated<gw_lcm::keyframe_t>(keyframe);
  EXPECT_EQ(generated.seq, delivery.seq);
  EXPECT_EQ(generated.session, delivery.session);
  EXPECT_EQ(generated.oldest_seq, delivery.oldest_seq);
  EXPECT_EQ(Decode<MapUpdate>(update)->seq, 42);
  EXPECT_EQ(Generated<gw_lcm::map_update_t>(update).oldest_seq, 40);
  EXPECT_EQ(Generated<gw_lcm::map_request_t>(request).session, delivery.session);
}

TEST(WireDelivery, OtherMessagesHaveNone) {
  EXPECT_FALSE(ReadDelivery(Encode(RandomMessages(1).Make<DrState>())));
  EXPECT_FALSE(ReadDelivery(Bytes(10)));
  EXPECT_FALSE(ReadDelivery({}));
  EXPECT_FALSE(ReadHeader(Bytes(23)));
}

}  // namespace
}  // namespace gw::wire

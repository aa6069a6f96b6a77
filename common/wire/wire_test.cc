// Encoding and decoding of every type but CAMERA, against lcm-gen's own code.
#include "common/wire/wire.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gw_lcm/ack_t.hpp>
#include <gw_lcm/base_command_t.hpp>
#include <gw_lcm/dr_t.hpp>
#include <gw_lcm/frame_detail_t.hpp>
#include <gw_lcm/frame_pose_t.hpp>
#include <gw_lcm/grid_t.hpp>
#include <gw_lcm/ground_truth_t.hpp>
#include <gw_lcm/health_t.hpp>
#include <gw_lcm/imu_t.hpp>
#include <gw_lcm/keyframe_t.hpp>
#include <gw_lcm/map_request_t.hpp>
#include <gw_lcm/map_update_t.hpp>
#include <gw_lcm/note_t.hpp>
#include <gw_lcm/obstacles_t.hpp>
#include <gw_lcm/place_match_t.hpp>
#include <gw_lcm/place_query_t.hpp>
#include <gw_lcm/pose_t.hpp>
#include <gw_lcm/wheel_t.hpp>

#include "common/wire/generated.h"
#include "common/wire/testing.h"

namespace gw::wire {
namespace {

using testing::RandomMessages;

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
void ExpectSame(const gw_lcm::frame_detail_t& g, const FrameDetail& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  EXPECT_EQ(g.alpha_translation, m.alpha_translation);
  EXPECT_EQ(g.alpha_rotation, m.alpha_rotation);
  EXPECT_EQ(g.quality, m.q);
  EXPECT_EQ(g.quality_close, m.q_close);
  EXPECT_EQ(g.bounded_translation, m.bounded_translation);
  EXPECT_EQ(g.bounded_rotation, m.bounded_rotation);
  EXPECT_EQ(g.alpha_bound, static_cast<int>(m.bound));
  for (int i = 0; i < 6; ++i) EXPECT_EQ(g.dr_share_B[i], m.dr_share[i]);
  ASSERT_EQ(g.features.size(), m.features.size());
  for (size_t i = 0; i < m.features.size(); ++i) {
    EXPECT_EQ(g.features[i].seen_u_px, m.features[i].u);
    EXPECT_EQ(g.features[i].seen_v_px, m.features[i].v);
    EXPECT_EQ(g.features[i].fate, static_cast<uint8_t>(m.features[i].fate));
  }
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
  EXPECT_EQ(g.reset_counter, m.reset_counter);
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
  EXPECT_EQ(g.piece_keyframe_id, m.piece.value);
  EXPECT_EQ(g.withdraws, m.withdraws);
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
  EXPECT_EQ(g.has_height, m.height.has_value());
  EXPECT_EQ(g.height_m, m.height.value_or(DrHeight{}).z);
  EXPECT_EQ(g.height_var_m2, m.height.value_or(DrHeight{}).variance);
  EXPECT_EQ(g.height_reset_counter, m.height.value_or(DrHeight{}).reset_counter);
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
void ExpectSame(const gw_lcm::grid_t& g, const GridUpdate& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  EXPECT_EQ(g.grid_session, m.grid_session);
  EXPECT_EQ(g.grid_version, m.grid_version);
  EXPECT_EQ(g.map_revision, m.map_revision);
  EXPECT_EQ(g.cell_m, m.cell_m);
  ASSERT_EQ(g.tiles.size(), m.tiles.size());
  for (size_t i = 0; i < m.tiles.size(); ++i) {
    EXPECT_EQ(g.tiles[i].tile_x, m.tiles[i].x);
    EXPECT_EQ(g.tiles[i].tile_y, m.tiles[i].y);
    EXPECT_EQ(g.tiles[i].tile_version, m.tiles[i].version);
    for (size_t k = 0; k < m.tiles[i].cells.size(); ++k) {
      ASSERT_EQ(g.tiles[i].cell_states[k], static_cast<uint8_t>(m.tiles[i].cells[k]));
    }
  }
}
void ExpectSame(const gw_lcm::obstacles_t& g, const ObstacleView& m) {
  EXPECT_EQ(g.utime, m.utime.us);
  EXPECT_EQ(g.seq, m.seq);
  EXPECT_EQ(g.cell_m, m.cell_m);
  EXPECT_EQ(g.seen_ahead_m, m.seen_ahead_m);
  ASSERT_EQ(g.obstacles.size(), m.obstacles.size());
  for (size_t i = 0; i < m.obstacles.size(); ++i) {
    EXPECT_EQ(g.obstacles[i].obstacle_x_B_m, m.obstacles[i].x());
    EXPECT_EQ(g.obstacles[i].obstacle_y_B_m, m.obstacles[i].y());
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
    Pair<FrameDetail, gw_lcm::frame_detail_t>, Pair<FramePose, gw_lcm::frame_pose_t>,
    Pair<Pose, gw_lcm::pose_t>, Pair<Health, gw_lcm::health_t>, Pair<Keyframe, gw_lcm::keyframe_t>,
    Pair<MapUpdate, gw_lcm::map_update_t>, Pair<MapRequest, gw_lcm::map_request_t>,
    Pair<GridUpdate, gw_lcm::grid_t>, Pair<ObstacleView, gw_lcm::obstacles_t>,
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

}  // namespace
}  // namespace gw::wire

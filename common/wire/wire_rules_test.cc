// What decoding refuses, one rule after the other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
#include <gw_lcm/obstacles_t.hpp>
#include <gw_lcm/pose_t.hpp>
#include <gw_lcm/wheel_t.hpp>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <utility>

#include "common/wire/frame_detail.h"
#include "common/wire/generated.h"
#include "common/wire/grid.h"
#include "common/wire/testing.h"
#include "common/wire/wire.h"

namespace gw::wire {
namespace {

using testing::RandomMessages;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

bool HasElements(const Keyframe& m) {
  return !m.features.empty();
}
bool HasElements(const MapUpdate& m) {
  return !m.keyframes.empty() && !m.landmarks.empty();
}
bool HasElements(const GridUpdate& m) {
  return m.tiles.size() == 2;
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

TEST(WireRules, TilesAreSortedAndTheirCellsAreKnownStates) {
  EXPECT_REFUSED(GridUpdate, grid_t, "cell_m", m.cell_m = 0);
  EXPECT_REFUSED(GridUpdate, grid_t, "tiles.tile_x", m.tiles[0].tile_x = 1 << 30);
  EXPECT_REFUSED(GridUpdate, grid_t, "tiles.cell_states", m.tiles[1].cell_states[1023] = 3);
  EXPECT_REFUSED(GridUpdate, grid_t, "tiles", std::swap(m.tiles[0], m.tiles[1]));
  EXPECT_REFUSED(GridUpdate, grid_t, "tiles", m.tiles[1] = m.tiles[0]);
  EXPECT_REFUSED(ObstacleView, obstacles_t, "seen_ahead_m", m.seen_ahead_m = -1);
}

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
  EXPECT_REFUSED(FramePose, frame_pose_t, "reason", m.reason = 14);
  EXPECT_REFUSED(Health, health_t, "state", m.state = 5);
  EXPECT_REFUSED(FramePose, frame_pose_t, "num_inliers", m.num_inliers = -1);
  EXPECT_REFUSED(FramePose, frame_pose_t, "quality", m.quality = 1.01);
  EXPECT_REFUSED(FramePose, frame_pose_t, "dr_share", m.dr_share = -0.01);
  EXPECT_REFUSED(FramePose, frame_pose_t, "alpha", m.alpha = -1);
  EXPECT_REFUSED(FrameDetail, frame_detail_t, "quality_close", m.quality_close = 1.01);
  EXPECT_REFUSED(FrameDetail, frame_detail_t, "bounded_rotation", m.bounded_rotation = -1);
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
  EXPECT_REFUSED(Keyframe, keyframe_t, "piece_keyframe_id", m.piece_keyframe_id = -1);
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
  const auto set = [](auto& landmark, const std::vector<std::pair<int64_t, int>>& list) {
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

// A message as an older type has it: its fingerprint, and without the fields that came later, each
// a range of bytes.
Bytes AsOf(uint64_t fingerprint, Bytes message,
           std::initializer_list<std::pair<size_t, size_t>> cut) {
  for (size_t i = 0; i < 8; ++i) message[i] = static_cast<uint8_t>(fingerprint >> (56 - 8 * i));
  for (auto range = std::rbegin(cut); range != std::rend(cut); ++range) {
    const auto begin = message.begin() + static_cast<std::ptrdiff_t>(range->first);
    message.erase(begin, begin + static_cast<std::ptrdiff_t>(range->second));
  }
  return message;
}

// Before there were pieces of a map, or keyframes that withdraw others; before lengths were
// corrected; before keyframes had a height.
TEST(WireRules, KeyframesOfBeforeAreRead) {
  constexpr size_t kPiece = 8 + 8 + 24 + 8 + 56 + 288 + 8 + 8;  // bytes before it
  constexpr size_t kHeight = kPiece + 8 + 1 + 8 + 1 + (8 + 8 + 56 + 288 + 8 + 1 + 1);
  Keyframe keyframe;
  do {
    keyframe = RandomMessages(static_cast<uint64_t>(keyframe.id.value) + 1).Make<Keyframe>();
  } while (!keyframe.piece.valid() || !keyframe.withdraws || !keyframe.height);
  EXPECT_FALSE(Decode<Keyframe>(AsOf(0x4d4cf13dcd24c456, Encode(keyframe), {})).ok()) << "too long";
  const auto without_height =
      Decode<Keyframe>(AsOf(0x3598c0f1cc8c8301, Encode(keyframe), {{kHeight, 25}}));
  ASSERT_TRUE(without_height.ok());
  keyframe.height.reset();
  EXPECT_EQ(Encode(*without_height), Encode(keyframe));
  const auto without_lengths = Decode<Keyframe>(
      AsOf(0x4d4cf13dcd24c456, Encode(keyframe), {{kPiece + 9, 8}, {kHeight, 25}}));
  ASSERT_TRUE(without_lengths.ok());
  keyframe.length_factor = 1;
  EXPECT_EQ(Encode(*without_lengths), Encode(keyframe));
  const auto without_pieces = Decode<Keyframe>(
      AsOf(0x3666777e63bcbaf8, Encode(keyframe), {{kPiece, 9 + 8}, {kHeight, 25}}));
  ASSERT_TRUE(without_pieces.ok());
  keyframe.piece = {};
  keyframe.withdraws = false;
  EXPECT_EQ(Encode(*without_pieces), Encode(keyframe));
}

TEST(WireRules, MapUpdatesOfBeforeAreRead) {
  constexpr size_t kFactor = 8 + 8 + 24 + 8 + 8 + 1 + 1 + 8;
  constexpr size_t kPiece = kFactor + 8 + 4 + 8 + 8 + 56;
  MapUpdate update;
  update.length_factor = 0.9;
  update.keyframes.push_back({{3}, {5}, SE3(), {2}});
  const auto without_lengths =
      Decode<MapUpdate>(AsOf(0xea9ec3d407e44639, Encode(update), {{kFactor, 8}}));
  ASSERT_TRUE(without_lengths.ok()) << without_lengths.error().message;
  update.length_factor = 1;
  EXPECT_EQ(Encode(*without_lengths), Encode(update));
  const auto without_pieces =
      Decode<MapUpdate>(AsOf(0xc60eb93846af94b6, Encode(update), {{kFactor, 8}, {kPiece, 8}}));
  ASSERT_TRUE(without_pieces.ok()) << without_pieces.error().message;
  update.keyframes[0].piece = {};
  EXPECT_EQ(Encode(*without_pieces), Encode(update));
}

}  // namespace
}  // namespace gw::wire

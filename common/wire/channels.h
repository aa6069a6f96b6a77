// Every LCM channel of the project, once. docs/channels.md shows this table (channels_test.cc keeps
// the two equal); no other file spells a channel name.
#pragma once

#include <array>
#include <string_view>

namespace gw::wire {

inline constexpr char kCamera[] = "CAMERA";
inline constexpr char kImu[] = "IMU";
inline constexpr char kWheel[] = "WHEEL";
inline constexpr char kDr[] = "DR";
inline constexpr char kFramePose[] = "FRAME_POSE";
inline constexpr char kFrameDetail[] = "FRAME_DETAIL";
inline constexpr char kPose[] = "POSE";
inline constexpr char kKeyframe[] = "KEYFRAME";
inline constexpr char kKeyframeAck[] = "KEYFRAME_ACK";
inline constexpr char kMapUpdate[] = "MAP_UPDATE";
inline constexpr char kMapUpdateAck[] = "MAP_UPDATE_ACK";
inline constexpr char kMapRequest[] = "MAP_REQUEST";
inline constexpr char kPlaceQuery[] = "PLACE_QUERY";
inline constexpr char kPlaceMatch[] = "PLACE_MATCH";
inline constexpr char kGrid[] = "GRID";
inline constexpr char kObstacles[] = "OBSTACLES";
inline constexpr char kHealth[] = "HEALTH";
inline constexpr char kBaseCommand[] = "BASE_COMMAND";
inline constexpr char kGroundTruth[] = "GROUND_TRUTH";
inline constexpr char kNote[] = "NOTE";

// What a receiver that is late does. In every case the loss is counted, by the gap in seq.
enum class QueuePolicy {
  kNewest,    // uses the newest; older ones may be dropped, the oldest first (docs/channels.md)
  kEvery,     // works through all of them; the queue below covers the longest stall we accept
  kReliable,  // as kEvery, and what is lost nevertheless is sent again
};

struct Channel {
  std::string_view name;
  std::string_view type;  // in package gw_lcm
  std::string_view publisher;
  std::string_view rate;
  QueuePolicy policy;
  // Messages that wait between the bus's receive thread and a subscriber; LCM drops the *newest*
  // when they are full, so the number covers a stall of a second or more also for kNewest.
  int queue_capacity;
};

inline constexpr std::array<Channel, 20> kChannels{{
    {kCamera, "camera_t", "gw-camera, gw-sim, importer", "30 Hz", QueuePolicy::kNewest, 30},
    {kImu, "imu_t", "gw-camera, gw-kobuki, gw-sim, importer", "100-400 Hz", QueuePolicy::kEvery,
     2000},
    {kWheel, "wheel_t", "gw-kobuki, gw-sim, importer", "20-50 Hz", QueuePolicy::kEvery, 500},
    {kDr, "dr_t", "gw-dr-ekf, importer", "rate of the IMU or gyro", QueuePolicy::kEvery, 2000},
    {kFramePose, "frame_pose_t", "gw-frontend", "every image", QueuePolicy::kNewest, 100},
    {kFrameDetail, "frame_detail_t", "gw-frontend", "every image", QueuePolicy::kNewest, 100},
    {kPose, "pose_t", "gw-dr-ekf", "DR rate", QueuePolicy::kNewest, 1000},
    {kKeyframe, "keyframe_t", "gw-frontend", "on demand", QueuePolicy::kReliable, 100},
    {kKeyframeAck, "ack_t", "gw-backend", "after each KEYFRAME", QueuePolicy::kNewest, 100},
    {kMapUpdate, "map_update_t", "gw-backend", "on demand", QueuePolicy::kReliable, 100},
    {kMapUpdateAck, "ack_t", "gw-frontend", "after each MAP_UPDATE", QueuePolicy::kNewest, 100},
    {kMapRequest, "map_request_t", "gw-frontend", "on demand", QueuePolicy::kNewest, 10},
    {kPlaceQuery, "place_query_t", "gw-frontend", "on demand", QueuePolicy::kNewest, 10},
    {kPlaceMatch, "place_match_t", "gw-backend", "after each PLACE_QUERY", QueuePolicy::kNewest,
     10},
    {kGrid, "grid_t", "gw-grid", "2 Hz", QueuePolicy::kEvery, 100},
    {kObstacles, "obstacles_t", "gw-grid", "5 or 10 Hz", QueuePolicy::kNewest, 30},
    {kHealth, "health_t", "every process", "1 Hz", QueuePolicy::kNewest, 100},
    {kBaseCommand, "base_command_t", "gw-navigate", "20 Hz", QueuePolicy::kNewest, 40},
    {kGroundTruth, "ground_truth_t", "gw-sim, importer", "any", QueuePolicy::kEvery, 1000},
    {kNote, "note_t", "importer, gw-fault, gw-sim, gw-navigate", "on demand", QueuePolicy::kEvery,
     100},
}};

// Null for a channel that is not ours.
constexpr const Channel* FindChannel(std::string_view name) {
  for (const Channel& channel : kChannels) {
    if (channel.name == name) return &channel;
  }
  return nullptr;
}

}  // namespace gw::wire

// From messages of the bus to messages for viewers: Foxglove's schemas for what they know, JSON of
// ours for the rest. Live, from a log and into an MCAP file it is the same code.
//
// Frames (docs/conventions.md): "world" W, "odometry" O, "body" B, "camera" C, "floor" the frame of
// the ground truth G, which is that of the floor map. Rates are limited by the times at which
// messages were received, so that the same log gives the same bytes. Holds the state that one who
// comes later must be told (State). Bad messages are counted and left out.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/contract/health.h"
#include "common/contract/samples.h"
#include "common/wire/frame_detail.h"
#include "common/wire/wire.h"
#include "tools/data/foxglove/line_scene.h"
#include "tools/data/foxglove/map_view.h"
#include "tools/data/foxglove/rate_limit.h"
#include "tools/data/foxglove/topics.h"
#include "tools/data/foxglove/truth_tie.h"

namespace gw::foxglove {

// Occupied cells of a floor map, row 0 at the lowest y.
struct FloorCells {
  int width = 0, height = 0;
  double resolution = 0;                             // m
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  // of cell (0, 0)'s corner in the floor map
  std::vector<uint8_t> occupied;                     // 1 or 0
};

struct TranslatorOptions {
  std::optional<CameraGeometry> camera;  // without it no camera frame, no exact place of features
  std::optional<FloorCells> floor;
  // The body's first pose in the floor map, for robots without ground truth; absent: W is the map.
  std::optional<SE3> T_GB_start;
};

class Translator {
 public:
  using Topics = std::bitset<kNumTopics>;

  explicit Translator(TranslatorOptions options);

  // Topics that somebody listens to; others cost nothing but their state. All at first.
  void SetWanted(const Topics& wanted) { wanted_ = wanted; }

  // A message of the bus. received: clock of the host or of the log, not decreasing but for logs
  // that were joined.
  void Take(std::string_view channel, wire::ByteSpan bytes, Utime received);
  // Time passes also without messages; a few times a second.
  void Tick(Utime now);

  // What has to be sent since the last call.
  std::vector<Message> Drain();
  // What one who begins to listen to the topic has to be told; empty for topics without a state.
  std::vector<Message> State(Topic topic);

  struct ChannelCount {
    int64_t messages = 0;
    int64_t lost = 0;  // by gaps in seq
    int64_t undecodable = 0;
    int64_t last_seq = 0;
  };
  const std::map<std::string, ChannelCount, std::less<>>& channels() const { return channels_; }
  const MapView& map() const { return map_; }

 private:
  bool Wants(Topic topic) const { return wanted_[static_cast<size_t>(topic)]; }
  void Emit(Topic topic, const Json& json);
  Message Make(Topic topic, const Json& json) const;
  void Log(int level, const std::string& name, const std::string& text, Utime utime);

  void Take(wire::ByteSpan camera);
  void Take(const FramePose& pose);
  void Take(const FrameDetail& detail);
  void Take(const Pose& pose);
  void Take(const DrState& state);
  void Take(const Keyframe& keyframe) { map_.Take(keyframe); }
  void Take(const MapUpdate& update);
  void Take(const Health& health);
  void Take(const GroundTruth& truth);
  void Take(const wire::Note& note);
  template <typename T>
  void TakeDecoded(wire::ByteSpan bytes, ChannelCount* count);

  std::optional<LineScene::Anchor> AnchorOf(const FramePose& pose) const;
  void SendTransforms(Utime utime, const SE3& T_WB);
  void SendLines();
  void SendMap();
  void SendError(Utime utime, const SE3& T_WB, const SE3& T_GB);
  SE3 T_WG() const;
  Json KeyframesJson() const;
  Json LandmarksJson() const;
  Json FloorJson() const;
  Json HealthJson(const std::string& process) const;

  struct Process {
    Health health;
    Health before;
    Utime received;
  };

  TranslatorOptions options_;
  Topics wanted_;
  std::vector<Message> messages_;
  Utime now_;  // received time of the newest message
  std::map<std::string, ChannelCount, std::less<>> channels_;

  MapView map_;
  bool map_changed_ = false;
  LineScene way_{{"pose", 3, 0.02}};
  LineScene dr_way_{{"dead reckoning", 1.5, 0.01}};
  LineScene truth_way_{{"ground truth", 1.5, 0.0}};
  std::map<std::string, Process> processes_;
  TruthTie tie_;
  std::optional<GroundTruth> last_truth_;
  std::optional<std::pair<Utime, SE3>> unchecked_;  // T_WB that waits for its ground truth
  double squared_errors_ = 0;
  int64_t num_errors_ = 0;

  SE3 T_WO_;
  std::optional<SE3> T_WO_start_;  // where dead reckoning's own way is drawn
  uint32_t dr_reset_counter_ = 0;
  std::optional<uint32_t> pose_reset_counter_;
  std::optional<FrameDetail> detail_;
  std::optional<FramePose> last_frame_;
  std::optional<Utime> last_pose_received_;
  std::vector<Utime> sent_images_;  // newest last, a few
  double image_scale_ = 1;

  RateLimit pose_rate_{Milliseconds(33)};
  RateLimit image_rate_{Milliseconds(100)};
  RateLimit dr_rate_{Milliseconds(100)};
  RateLimit error_rate_{Milliseconds(100)};
  RateLimit line_rate_{Milliseconds(250)};
  RateLimit map_rate_{Milliseconds(1000)};
  RateLimit silent_rate_{Milliseconds(1000)};
};

}  // namespace gw::foxglove

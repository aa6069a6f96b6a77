// What viewers are told: the topics, and the schema of each. Topics with schemas "foxglove.*" are
// those that Foxglove's own clients draw
// (https://docs.foxglove.dev/docs/visualization/message-schemas); "gw.*" are ours. All messages are
// JSON. The schema texts are the files in schemas/, built in.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "common/core/time.h"

namespace gw::foxglove {

enum class Topic : uint8_t {
  kTransforms,
  kPose,
  kTrajectory,
  kKeyframes,
  kLandmarks,
  kFloor,
  kImage,
  kFeatures,
  kCalibration,
  kWeights,
  kDeadReckoning,
  kError,
  kHealth,
  kLog,
  kViewer,
};
inline constexpr size_t kNumTopics = 15;

// What a client that is slow, or comes late, needs.
enum class Delivery : uint8_t {
  kEvery,   // each message counts; the oldest waiting one is dropped
  kNewest,  // a newer message replaces the one that waits
  kState,   // messages change a state; who missed one needs the whole state again
};

struct TopicInfo {
  std::string_view name;
  std::string_view schema_name;
  Delivery delivery;
};

inline constexpr std::array<TopicInfo, kNumTopics> kTopics{{
    {"/tf", "foxglove.FrameTransforms", Delivery::kNewest},
    {"/pose", "foxglove.PoseInFrame", Delivery::kNewest},
    {"/trajectory", "foxglove.SceneUpdate", Delivery::kState},
    {"/map/keyframes", "foxglove.SceneUpdate", Delivery::kNewest},
    {"/map/landmarks", "foxglove.PointCloud", Delivery::kNewest},
    {"/floor", "foxglove.Grid", Delivery::kNewest},
    {"/camera/image", "foxglove.CompressedImage", Delivery::kNewest},
    {"/camera/features", "foxglove.ImageAnnotations", Delivery::kNewest},
    {"/camera/calibration", "foxglove.CameraCalibration", Delivery::kNewest},
    {"/weights", "gw.Weights", Delivery::kEvery},
    {"/dead_reckoning", "gw.DeadReckoning", Delivery::kNewest},
    {"/error", "gw.Error", Delivery::kNewest},
    {"/health", "gw.Health", Delivery::kState},
    {"/log", "foxglove.Log", Delivery::kEvery},
    {"/viewer", "gw.Viewer", Delivery::kNewest},
}};

inline const TopicInfo& Info(Topic topic) {
  return kTopics[static_cast<size_t>(topic)];
}

// JSON Schema of a schema name. Precondition: one of kTopics.
std::string_view SchemaText(std::string_view schema_name);

// One message for viewers.
struct Message {
  Topic topic = Topic::kTransforms;
  Utime received;  // of the message on the bus that it was made from
  std::shared_ptr<const std::string> json;
};

}  // namespace gw::foxglove

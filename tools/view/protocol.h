// The Foxglove WebSocket protocol, version 1: what the two sides say to each other, as text.
// https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md. Server to client only; what
// clients would publish, call or fetch is refused, so that nothing reaches the robot through it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "tools/data/foxglove/topics.h"

namespace gw::view {

inline constexpr std::string_view kSubprotocol = "foxglove.websocket.v1";

enum class StatusLevel { kInfo = 0, kWarning = 1, kError = 2 };

// Channel ids are those of the topics, plus one.
inline uint32_t ChannelId(foxglove::Topic topic) {
  return static_cast<uint32_t>(topic) + 1;
}
std::optional<foxglove::Topic> TopicOfChannel(uint64_t channel_id);

// seekable: a log is played, whose place and speed are parameters.
std::string ServerInfo(const std::string& name, const std::string& session, bool seekable);
std::string Advertise();
std::string Status(StatusLevel level, const std::string& text);
// MESSAGE_DATA: opcode, subscription, time of reception in ns, payload; little-endian.
std::string MessageData(uint32_t subscription, uint64_t time_ns, std::string_view payload);

// What a log's player is asked and says; names of parameters as in Foxglove's panel.
inline constexpr std::string_view kPositionParameter = "/playback/position_s";
inline constexpr std::string_view kSpeedParameter = "/playback/speed";
inline constexpr std::string_view kPausedParameter = "/playback/paused";
inline constexpr std::string_view kDurationParameter = "/playback/duration_s";

struct Playback {
  double position_s = 0, duration_s = 0, speed = 1;
  bool paused = false;
};
std::string ParameterValues(const Playback& playback, const std::optional<std::string>& id);

// What clients say.
struct Subscribe {
  std::vector<std::pair<uint32_t, uint64_t>> subscriptions;  // subscription id, channel id
};
struct Unsubscribe {
  std::vector<uint32_t> subscriptions;
};
struct GetParameters {
  std::optional<std::string> id;
};
struct SetParameters {
  std::optional<std::string> id = {};
  std::optional<double> position_s = {}, speed = {};
  std::optional<bool> paused = {};
};
struct SubscribeParameters {
  bool on = true;
};
// Part of the protocol, and not offered.
struct NotOffered {
  std::string op;
};
struct Malformed {
  std::string why;
};
using ClientMessage = std::variant<Subscribe, Unsubscribe, GetParameters, SetParameters,
                                   SubscribeParameters, NotOffered, Malformed>;

// Never throws; at most kMaxSubscriptions are taken from one message.
ClientMessage ParseClientMessage(std::string_view text);

inline constexpr size_t kMaxSubscriptions = 256;

}  // namespace gw::view

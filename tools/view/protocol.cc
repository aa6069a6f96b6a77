#include "tools/view/protocol.h"

#include <cmath>

#include "common/core/version.h"
#include "tools/data/files/json.h"

namespace gw::view {
namespace {

using tools::Json;

std::optional<std::string> IdOf(const Json& message) {
  const auto id = message.find("id");
  if (id == message.end() || !id->is_string()) return std::nullopt;
  return id->get<std::string>();
}

bool IsId(const Json& value) {
  return value.is_number_unsigned() && value.get<uint64_t>() <= UINT32_MAX;
}

ClientMessage ParseSubscribe(const Json& message) {
  Subscribe subscribe;
  for (const Json& entry : message.at("subscriptions")) {
    const Json& id = entry.at("id");
    const Json& channel = entry.at("channelId");
    if (!IsId(id) || !IsId(channel)) return Malformed{"subscribe: ids are numbers"};
    if (subscribe.subscriptions.size() >= kMaxSubscriptions) {
      return Malformed{"subscribe: too many subscriptions"};
    }
    subscribe.subscriptions.emplace_back(id.get<uint32_t>(), channel.get<uint64_t>());
  }
  return subscribe;
}

ClientMessage ParseUnsubscribe(const Json& message) {
  Unsubscribe unsubscribe;
  for (const Json& id : message.at("subscriptionIds")) {
    if (!IsId(id)) return Malformed{"unsubscribe: ids are numbers"};
    if (unsubscribe.subscriptions.size() >= kMaxSubscriptions) break;
    unsubscribe.subscriptions.push_back(id.get<uint32_t>());
  }
  return unsubscribe;
}

ClientMessage ParseSetParameters(const Json& message) {
  SetParameters set;
  set.id = IdOf(message);
  for (const Json& parameter : message.at("parameters")) {
    const auto& name = parameter.at("name").get_ref<const std::string&>();
    const Json value = parameter.contains("value") ? parameter["value"] : Json();
    if (value.is_number() && !std::isfinite(value.get<double>())) continue;
    if (name == kPositionParameter && value.is_number()) set.position_s = value.get<double>();
    if (name == kSpeedParameter && value.is_number()) set.speed = value.get<double>();
    if (name == kPausedParameter && value.is_boolean()) set.paused = value.get<bool>();
  }
  return set;
}

ClientMessage ParseObject(const Json& message) {
  const auto& op = message.at("op").get_ref<const std::string&>();
  if (op == "subscribe") return ParseSubscribe(message);
  if (op == "unsubscribe") return ParseUnsubscribe(message);
  if (op == "getParameters") return GetParameters{IdOf(message)};
  if (op == "setParameters") return ParseSetParameters(message);
  if (op == "subscribeParameterUpdates") return SubscribeParameters{true};
  if (op == "unsubscribeParameterUpdates") return SubscribeParameters{false};
  return NotOffered{op.substr(0, 40)};
}

}  // namespace

std::optional<foxglove::Topic> TopicOfChannel(uint64_t channel_id) {
  if (channel_id < 1 || channel_id > foxglove::kNumTopics) return std::nullopt;
  return static_cast<foxglove::Topic>(channel_id - 1);
}

std::string ServerInfo(const std::string& name, const std::string& session, bool seekable) {
  Json capabilities = Json::array();
  if (seekable) capabilities = {"parameters", "parametersSubscribe"};
  return tools::JsonLine({{"op", "serverInfo"},
                          {"name", name},
                          {"capabilities", capabilities},
                          {"supportedEncodings", {"json"}},
                          {"metadata", {{"version", Version()}}},
                          {"sessionId", session}});
}

std::string Advertise() {
  Json channels = Json::array();
  for (size_t i = 0; i < foxglove::kNumTopics; ++i) {
    const foxglove::TopicInfo& info = foxglove::kTopics[i];
    channels.push_back({{"id", ChannelId(static_cast<foxglove::Topic>(i))},
                        {"topic", info.name},
                        {"encoding", "json"},
                        {"schemaName", info.schema_name},
                        {"schema", foxglove::SchemaText(info.schema_name)},
                        {"schemaEncoding", "jsonschema"}});
  }
  return tools::JsonLine({{"op", "advertise"}, {"channels", std::move(channels)}});
}

std::string Status(StatusLevel level, const std::string& text) {
  return tools::JsonLine({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", text}});
}

std::string MessageData(uint32_t subscription, uint64_t time_ns, std::string_view payload) {
  std::string bytes;
  bytes.reserve(13 + payload.size());
  bytes.push_back(1);
  for (int shift = 0; shift < 32; shift += 8)
    bytes.push_back(static_cast<char>(subscription >> shift));
  for (int shift = 0; shift < 64; shift += 8) bytes.push_back(static_cast<char>(time_ns >> shift));
  bytes.append(payload);
  return bytes;
}

std::string ParameterValues(const Playback& playback, const std::optional<std::string>& id) {
  const auto number = [](std::string_view name, double value) {
    return Json{{"name", name}, {"value", value}, {"type", "float64"}};
  };
  Json message = {
      {"op", "parameterValues"},
      {"parameters",
       {number(kPositionParameter, playback.position_s),
        number(kDurationParameter, playback.duration_s), number(kSpeedParameter, playback.speed),
        Json{{"name", kPausedParameter}, {"value", playback.paused}}}}};
  if (id) message["id"] = *id;
  return tools::JsonLine(message);
}

ClientMessage ParseClientMessage(std::string_view text) {
  try {
    const Json message = Json::parse(text);
    return ParseObject(message);
  } catch (const Json::exception& error) {
    return Malformed{std::string("not a message of the protocol: ") + error.what()};
  }
}

}  // namespace gw::view

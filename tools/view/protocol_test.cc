#include "tools/view/protocol.h"

#include <gtest/gtest.h>

#include "common/core/random.h"
#include "tools/data/files/json.h"

namespace gw::view {
namespace {

using tools::Json;

TEST(Protocol, EveryTopicIsAdvertisedWithItsSchema) {
  const Json message = Json::parse(Advertise());
  ASSERT_EQ(message["channels"].size(), foxglove::kNumTopics);
  for (const Json& channel : message["channels"]) {
    EXPECT_EQ(channel["encoding"], "json");
    const Json schema = Json::parse(channel["schema"].get<std::string>());
    EXPECT_EQ(schema["title"], channel["schemaName"]);
    ASSERT_TRUE(TopicOfChannel(channel["id"].get<uint64_t>()));
  }
  EXPECT_FALSE(TopicOfChannel(0));
  EXPECT_FALSE(TopicOfChannel(foxglove::kNumTopics + 1));
}

TEST(Protocol, MessageDataIsLittleEndian) {
  const std::string bytes = MessageData(0x01020304, 0x1122334455667788, "xy");
  EXPECT_EQ(bytes, std::string("\x01\x04\x03\x02\x01\x88\x77\x66\x55\x44\x33\x22\x11xy"));
}

TEST(Protocol, UnderstandsWhatClientsSay) {
  const auto subscribe = ParseClientMessage(
      R"({"op":"subscribe","subscriptions":[{"id":7,"channelId":2},{"id":8,"channelId":3}]})");
  ASSERT_TRUE(std::holds_alternative<Subscribe>(subscribe));
  EXPECT_EQ(std::get<Subscribe>(subscribe).subscriptions[1], (std::pair<uint32_t, uint64_t>{8, 3}));
  const auto set = ParseClientMessage(
      R"({"op":"setParameters","id":"a","parameters":[{"name":"/playback/position_s","value":12.5},
          {"name":"/playback/paused","value":true},{"name":"other"}]})");
  ASSERT_TRUE(std::holds_alternative<SetParameters>(set));
  EXPECT_EQ(std::get<SetParameters>(set).position_s, 12.5);
  EXPECT_EQ(std::get<SetParameters>(set).paused, true);
  EXPECT_FALSE(std::get<SetParameters>(set).speed);
  EXPECT_TRUE(std::holds_alternative<NotOffered>(ParseClientMessage(R"({"op":"advertise"})")));
}

TEST(Protocol, NonsenseIsMalformedAndNothingElse) {
  for (const char* text : {"", "{", "[]", "null", "7", R"({"op":7})", R"({"op":"subscribe"})",
                           R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})",
                           R"({"op":"subscribe","subscriptions":[{"id":1e30,"channelId":1}]})",
                           R"({"op":"subscribe","subscriptions":{"a":1}})", "\xff\xfe"}) {
    EXPECT_TRUE(std::holds_alternative<Malformed>(ParseClientMessage(text))) << text;
  }
}

TEST(Protocol, AnyBytesAreSurvived) {
  CounterRng rng(3, 0, 0);
  const std::string valid =
      R"({"op":"setParameters","parameters":[{"name":"/playback/speed","value":2}]})";
  for (int i = 0; i < 20'000; ++i) {
    std::string text = valid;
    for (int k = 0; k < 3; ++k)
      text[rng.Below(static_cast<uint32_t>(text.size()))] = static_cast<char>(rng.Below(256));
    ParseClientMessage(text);
  }
  ParseClientMessage(std::string(60'000, '['));
}

}  // namespace
}  // namespace gw::view

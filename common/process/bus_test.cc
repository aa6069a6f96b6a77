#include "common/process/bus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace gw::process {
namespace {

using Bytes = std::vector<uint8_t>;

TEST(MemoryBus, HandsOverInOrderOfPublishing) {
  MemoryBus bus;
  std::vector<std::pair<char, uint8_t>> seen;
  ASSERT_TRUE(bus.Subscribe("IMU", [&](auto m, Utime) { seen.emplace_back('i', m[0]); }).ok());
  ASSERT_TRUE(bus.Subscribe("DR", [&](auto m, Utime) { seen.emplace_back('d', m[0]); }).ok());
  for (uint8_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(bus.Publish("IMU", Bytes{i}).ok());
    ASSERT_TRUE(bus.Publish("DR", Bytes{i}).ok());
    ASSERT_TRUE(bus.Publish("POSE", Bytes{i}).ok());  // nobody listens
  }
  EXPECT_EQ(*bus.Pump(0), 9);
  using P = std::pair<char, uint8_t>;
  EXPECT_THAT(seen, ::testing::ElementsAre(P{'i', 0}, P{'d', 0}, P{'i', 1}, P{'d', 1}, P{'i', 2},
                                           P{'d', 2}));
  EXPECT_EQ(*bus.Pump(0), 0);
}

TEST(MemoryBus, AnswersWaitForTheNextPump) {
  MemoryBus bus;
  int answers = 0;
  (void)bus.Subscribe("KEYFRAME", [&](auto m, Utime) { (void)bus.Publish("KEYFRAME_ACK", m); });
  (void)bus.Subscribe("KEYFRAME_ACK", [&](auto, Utime) { ++answers; });
  (void)bus.Publish("KEYFRAME", Bytes{1});
  EXPECT_EQ(*bus.Pump(0), 1);
  EXPECT_EQ(answers, 0);
  EXPECT_EQ(*bus.Pump(-1), 1);  // is readable, so this does not wait
  EXPECT_EQ(answers, 1);
}

TEST(MemoryBus, StampsArrivals) {
  MemoryBus bus;
  Utime seen;
  (void)bus.Subscribe("IMU", [&](auto, Utime received) { seen = received; });
  bus.set_now(Utime{123});
  (void)bus.Publish("IMU", Bytes{1});
  (void)bus.Pump(0);
  EXPECT_EQ(seen.us, 123);
}

TEST(LiveBus, MalformedUrlsAreErrorsBeforeLcmSeesThem) {
  for (const char* url :
       {"", "nonsense", "udpm://", "udpm://239.255.76.67", "udpm://239.255.76.67:0",
        "udpm://239.255.76.67:70000", "udpm://239.255.76.300:7667", "udpm://192.168.0.1:7667",
        "udpm://239.255.76.67:7667?ttl", "udpm://239.255.76.67:7667?ttl=0&recv_buffer=4",
        "udpm://239.255.76.67:7667?recv_buf_size=4M", "memq://", "file:///tmp/x"}) {
    const auto bus = LiveBus::Create(url);
    ASSERT_FALSE(bus.ok()) << url;
    EXPECT_EQ(bus.error().code, ErrorCode::kBadConfig);
    EXPECT_THAT(bus.error().message, ::testing::HasSubstr("udpm://239.255.76.67:7667"));
  }
}

}  // namespace
}  // namespace gw::process

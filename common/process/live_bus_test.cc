// Over real multicast, on a port of its own and with ttl=0: nothing leaves this host.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <stdexcept>

#include "common/process/bus.h"

namespace gw::process {
namespace {

using Bytes = std::vector<uint8_t>;

class LiveBusTest : public ::testing::Test {
 protected:
  void SetUp() override {
    bus_ = Open("&recv_buf_size=1048576");
    if (!bus_) GTEST_SKIP() << "no multicast on this host";
    // The first subscription starts LCM's receive thread and its self test.
    if (!bus_->Subscribe("NOTE", [](auto, Utime) {}).ok()) {
      bus_.reset();
      GTEST_SKIP() << "multicast does not come back on this host";
    }
  }

  static std::unique_ptr<LiveBus> Open(const std::string& options) {
    const int port = 20000 + ::getpid() % 20000;
    auto bus = LiveBus::Create("udpm://239.255.76.68:" + std::to_string(port) + "?ttl=0" + options);
    return bus.ok() ? std::move(*bus) : nullptr;
  }

  // Until `count` messages came, or nothing for five seconds.
  void PumpUntil(const int& received, int count) {
    while (received < count) {
      const auto handled = bus_->Pump(5000);
      ASSERT_TRUE(handled.ok());
      if (*handled == 0) break;
    }
    EXPECT_EQ(received, count);
  }

  std::unique_ptr<LiveBus> bus_;
};

TEST_F(LiveBusTest, CarriesSmallAndLargeMessages) {
  std::vector<Bytes> seen;
  int count = 0;
  ASSERT_TRUE(bus_->Subscribe("CAMERA",
                              [&](auto m, Utime) {
                                seen.emplace_back(m.begin(), m.end());
                                ++count;
                              })
                  .ok());
  const Bytes small = {1, 2, 3};
  // Two datagrams. More may not fit into the kernel's default receive buffer (212 kB, of which
  // small MTUs waste almost half), which is what a host without our sysctl setting grants.
  Bytes image(100'000);
  for (size_t i = 0; i < image.size(); ++i) image[i] = static_cast<uint8_t>(i * 7);
  ASSERT_TRUE(bus_->Publish("CAMERA", small).ok());
  ASSERT_TRUE(bus_->Publish("CAMERA", image).ok());
  PumpUntil(count, 2);
  EXPECT_THAT(seen, ::testing::ElementsAre(small, image));
}

TEST_F(LiveBusTest, KeepsEveryImuSampleOfAStall) {
  int count = 0;
  int expected = 0;
  bool in_order = true;
  ASSERT_TRUE(bus_->Subscribe("IMU",
                              [&](auto m, Utime) {
                                in_order = in_order && m[0] == (count & 0xFF);
                                ++count;
                              })
                  .ok());
  // The process is busy elsewhere meanwhile: LCM's default queue would keep 30. No more than fit
  // into the kernel's default receive buffer at once.
  for (; expected < 100; ++expected) {
    ASSERT_TRUE(bus_->Publish("IMU", Bytes(100, static_cast<uint8_t>(expected))).ok());
  }
  PumpUntil(count, expected);
  EXPECT_TRUE(in_order);
}

TEST_F(LiveBusTest, HoldsNoMoreImagesThanItIsTold) {
  int images = 0, samples = 0;
  bus_->HoldImages(3);
  ASSERT_TRUE(bus_->Subscribe("CAMERA", [&](auto, Utime) { ++images; }).ok());
  ASSERT_TRUE(bus_->Subscribe("IMU", [&](auto, Utime) { ++samples; }).ok());
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(bus_->Publish("CAMERA", Bytes(100)).ok());
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(bus_->Publish("IMU", Bytes(100)).ok());
  ::usleep(200'000);  // until all have arrived, and no more than three images were kept
  PumpUntil(samples, 10);
  EXPECT_GE(images, 1);
  EXPECT_LE(images, 3 + 1);  // LCM holds one more
}

TEST_F(LiveBusTest, HandlersMayThrow) {
  int count = 0;
  ASSERT_TRUE(bus_->Subscribe("DR",
                              [&](auto, Utime) {
                                if (++count == 1) throw std::runtime_error("first");
                              })
                  .ok());
  ASSERT_TRUE(bus_->Publish("DR", Bytes{1}).ok());
  ASSERT_TRUE(bus_->Publish("DR", Bytes{2}).ok());
  EXPECT_THROW((void)bus_->Pump(5000), std::runtime_error);
  PumpUntil(count, 2);
}

TEST_F(LiveBusTest, RefusesChannelsThatAreNotInTheTable) {
  EXPECT_FALSE(bus_->Subscribe("IMAGES", [](auto, Utime) {}).ok());
}

TEST_F(LiveBusTest, SaysWhenTheReceiveBufferIsTooSmall) {
  const auto too_much = Open("&recv_buf_size=999999999");
  ASSERT_TRUE(too_much);
  EXPECT_THAT(too_much->warning(), ::testing::HasSubstr("sysctl -w net.core.rmem_max=999999999"));
  const auto too_little = Open("&recv_buf_size=65536");
  ASSERT_TRUE(too_little);
  EXPECT_THAT(too_little->warning(), ::testing::HasSubstr("add recv_buf_size="));
}

}  // namespace
}  // namespace gw::process

#include "common/process/loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "common/process/bus.h"
#include "common/process/clock.h"
#include "common/process/sd_notify.h"

namespace gw::process {
namespace {

TEST(Loop, TicksWakeIt) {
  auto loop = Loop::Create(DurationUs{1000});
  ASSERT_TRUE(loop.ok());
  for (int i = 0; i < 3; ++i) {
    const auto ready = loop->Wait();
    ASSERT_TRUE(ready.ok());
    EXPECT_TRUE(ready->tick);
    EXPECT_FALSE(ready->stop);
  }
}

TEST(Loop, SignalsStopItInsteadOfKillingTheProcess) {
  for (const int signal : {SIGTERM, SIGINT}) {
    auto loop = Loop::Create(Milliseconds(100'000));
    ASSERT_TRUE(loop.ok());
    ::raise(signal);
    EXPECT_TRUE(loop->Wait()->stop);
  }
}

TEST(Loop, MessagesWakeIt) {
  auto loop = Loop::Create(Milliseconds(100'000));
  ASSERT_TRUE(loop.ok());
  MemoryBus bus;
  MemoryBus idle;
  loop->Watch(bus.fd());
  loop->Watch(idle.fd());
  (void)bus.Publish("IMU", std::vector<uint8_t>{1});
  EXPECT_THAT(loop->Wait()->fds, ::testing::ElementsAre(bus.fd()));
  (void)idle.Publish("IMU", std::vector<uint8_t>{1});
  loop->Unwatch(bus.fd());
  EXPECT_THAT(loop->Wait()->fds, ::testing::ElementsAre(idle.fd()));
}

TEST(SdNotify, SendsTheDatagramsOfSystemd) {
  const std::string path = ::testing::TempDir() + "gw_notify_" + std::to_string(::getpid());
  FileHandle server(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof(address.sun_path) - 1);
  ASSERT_EQ(::bind(server.get(), reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
  const SdNotify notify;
  ::unsetenv("NOTIFY_SOCKET");
  notify.Ready();
  notify.Watchdog();
  notify.Stopping();
  for (const std::string expected : {"READY=1", "WATCHDOG=1", "STOPPING=1"}) {
    char buffer[64];
    const ssize_t size = ::recv(server.get(), buffer, sizeof(buffer), MSG_DONTWAIT);
    ASSERT_GT(size, 0);
    EXPECT_EQ(std::string(buffer, size), expected);
  }
  std::filesystem::remove(path);
}

TEST(SdNotify, IsSilentWithoutSystemd) {
  ::unsetenv("NOTIFY_SOCKET");
  const SdNotify notify;
  EXPECT_FALSE(notify.active());
  notify.Ready();
}

TEST(Clock, AllProcessesShareTheOffsetOfTheFirst) {
  const std::string path = ::testing::TempDir() + "gw_offset_" + std::to_string(::getpid());
  std::filesystem::remove(path);
  const Clock first(path);
  EXPECT_TRUE(first.shared());
  std::ofstream(path) << 1'000'000'000'000'000;  // as if the system's clock had been set since
  const Clock second(path);
  EXPECT_TRUE(second.shared());
  EXPECT_GE(second.Now().us, 1'000'000'000'000'000);
  EXPECT_LT(second.Now().us, 1'600'000'000'000'000);
  std::filesystem::remove(path);
}

TEST(Clock, WorksWithoutAPlaceForTheOffset) {
  const Clock clock("/nonexistent/folder/offset");
  EXPECT_FALSE(clock.shared());
  const Utime a = clock.Now();
  EXPECT_GT(a.us, 1'600'000'000'000'000);
  EXPECT_GE(clock.Now(), a);
}

}  // namespace
}  // namespace gw::process

// Tests of serial port, node and program on a pseudo terminal, in real time. Nothing here asserts
// how long something takes: each waits until it happens, and the test's time limit is the only
// clock.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>

#include "common/process/clock.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "drivers/kobuki/device/kobuki_node.h"
#include "test/emulators/kobuki/pty_base.h"

namespace gw::kobuki {
namespace {

using testing::HasSubstr;

std::string TempPath(const std::string& name) {
  return testing::TempDir() + "kobuki_" + std::to_string(::getpid()) + "_" + name;
}

// The node on a memory bus, served as main does.
class DeviceTest : public testing::Test {
 protected:
  DeviceTest() : link_(TempPath("port")), clock_(TempPath("offset")) {
    config_.drivers.kobuki.device = link_;
    auto base = PtyBase::Create({}, link_);
    EXPECT_TRUE(base);
    base_ = std::move(*base);
    EXPECT_TRUE(bus_.Subscribe(wire::kWheel, [this](auto message, Utime) {
      const auto sample = wire::Decode<WheelSample>(message);
      ASSERT_TRUE(sample) << sample.error().message;
      wheel_.push_back(*sample);
    }));
    EXPECT_TRUE(bus_.Subscribe(wire::kHealth, [this](auto message, Utime) {
      const auto health = wire::Decode<Health>(message);
      ASSERT_TRUE(health) << health.error().message;
      health_ = *health;
    }));
    node_ = std::make_unique<KobukiNode>(
        config_, &bus_, [this] { return clock_.Now(); },
        process::LogLine(Milliseconds(0), [this](const std::string& line) { log_ += line; }));
    EXPECT_TRUE(node_->Start());
  }
  ~DeviceTest() override {
    node_.reset();
    std::remove(TempPath("offset").c_str());
  }

  void Until(const std::function<bool()>& done) {
    Utime next_tick{0};
    while (!done()) {
      pollfd port{node_->port_fd(), POLLIN, 0};
      ::poll(&port, port.fd >= 0 ? 1 : 0, 2);
      if (port.revents != 0) node_->ReadPort();
      bus_.set_now(clock_.Now());
      ASSERT_TRUE(bus_.Pump(0));
      if (clock_.Now() >= next_tick) {
        node_->Tick();
        next_tick = clock_.Now() + Milliseconds(5);
      }
    }
  }
  void Command(double v) {
    ASSERT_TRUE(
        bus_.Publish(wire::kBaseCommand, wire::Encode(BaseCommand{clock_.Now(), ++seq_, v, 0})));
  }
  double RobotSpeed() {
    double v = 0;
    base_->With([&](Emulator& robot) { v = robot.commanded().v_m_s; });
    return v;
  }

  std::string link_;
  process::Clock clock_;
  RobotConfig config_;
  process::MemoryBus bus_;
  std::unique_ptr<PtyBase> base_;
  std::unique_ptr<KobukiNode> node_;
  std::vector<WheelSample> wheel_;
  Health health_;
  std::string log_;
  int64_t seq_ = 0;
};

TEST_F(DeviceTest, DrivesReportsAndStopsOnShutdown) {
  Until([&] { return wheel_.size() > 10; });
  Until([&] {
    Command(0.3);
    return RobotSpeed() > 0.1;
  });
  Until([&] {
    Command(0.3);
    return !wheel_.empty() && wheel_.back().dx_m > 0.001;
  });
  Until([&] { return health_.state == HealthState::kOk; });
  EXPECT_EQ(health_.process, "gw-kobuki");
  Command(0.3);
  node_->Shutdown();
  // The emulator reads in its own thread.
  while (RobotSpeed() != 0) ::poll(nullptr, 0, 1);
}

TEST_F(DeviceTest, SurvivesUnpluggingAndComesBack) {
  Until([&] { return wheel_.size() > 5; });
  base_->Unplug();
  Until([&] { return node_->link_state() == LinkState::kAbsent; });
  Until([&] { return health_.state == HealthState::kFailed; });
  EXPECT_THAT(log_, HasSubstr("kobuki.gone"));
  const size_t before = wheel_.size();
  const int64_t last_seq = wheel_.back().seq;
  ASSERT_TRUE(base_->Plug());
  Until([&] { return wheel_.size() > before + 5; });
  EXPECT_EQ(wheel_[before].seq, last_seq + 1);
}

TEST_F(DeviceTest, SilentIsNotAbsent) {
  Until([&] { return wheel_.size() > 5; });
  base_->With([](Emulator& robot) { robot.SetSilent(true); });
  Until([&] { return node_->link_state() == LinkState::kSilent; });
  Until([&] { return health_.message.find("switch the base on") != std::string::npos; });
  EXPECT_EQ(health_.state, HealthState::kDegraded);
  base_->With([](Emulator& robot) { robot.SetSilent(false); });
  Until([&] { return node_->link_state() == LinkState::kTalking; });
}

TEST_F(DeviceTest, GarbageIsNamed) {
  base_->SendGarbage({'$', 'G', 'P', 'G', 'G', 'A', '\r', '\n'});
  Until([&] { return node_->link_state() == LinkState::kGarbage; });
  EXPECT_THAT(node_->LinkMessage(), HasSubstr("another device"));
  base_->With([](Emulator& robot) { EXPECT_EQ(robot.commands(), 0); });
}

TEST_F(DeviceTest, PortIsOursAlone) {
  Until([&] { return node_->link_state() == LinkState::kTalking; });
  const auto second = SerialPort::Open(link_);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message, HasSubstr("in use"));
}

TEST(SerialPort, BadPathsHaveOneClearMessage) {
  const auto none = SerialPort::Open("/dev/no_such_port");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(none.error().message, HasSubstr("/dev/no_such_port: no such device"));
  const auto null = SerialPort::Open("/dev/null");
  ASSERT_FALSE(null);
  EXPECT_EQ(null.error().code, ErrorCode::kBadData);
  EXPECT_THAT(null.error().message, HasSubstr("not a serial port"));
  if (::geteuid() == 0) GTEST_SKIP() << "root may open everything: permission is not tested";
  const std::string path = TempPath("forbidden");
  std::ofstream(path) << "";
  ::chmod(path.c_str(), 0);
  EXPECT_THAT(SerialPort::Open(path).error().message, HasSubstr("group dialout"));
  std::remove(path.c_str());
}

// What the program gave with --check: one line and a documented exit code for every kind of input.
struct Outcome {
  int exit_code = -1;
  std::string out, err;
};

std::string Slurp(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Writes the configuration of a robot whose base is at this port.
std::string WriteConfig(const std::string& device) {
  std::string text = Slurp(std::string(GW_SOURCE_DIR) + "/config/robots/turtlebot2_d435i.yaml");
  text += "\ndrivers:\n  kobuki:\n    device: " + device + "\n";
  const std::string path = TempPath("robot.yaml");
  std::ofstream(path) << text;
  return path;
}

Outcome RunCheck(const std::string& device) {
  const std::string config = WriteConfig(device);
  const std::string out = TempPath("out");
  const std::string err = TempPath("err");
  const std::string command = std::string(GW_BINARY_DIR) + "/gw-kobuki --check --config " + config +
                              " >" + out + " 2>" + err;
  const int status = std::system(command.c_str());
  const Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : -1, Slurp(out), Slurp(err)};
  for (const auto& path : {config, out, err}) std::remove(path.c_str());
  return outcome;
}

TEST(KobukiProgram, CheckNamesTheBase) {
  const std::string link = TempPath("port");
  auto base = PtyBase::Create({}, link);
  ASSERT_TRUE(base);
  const Outcome outcome = RunCheck(link);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("hardware 1.0.4, firmware 1.2.0, 16.3 V"));
}

TEST(KobukiProgram, CheckSaysWhatIsWrong) {
  const std::string link = TempPath("port");
  auto base = PtyBase::Create({}, link);
  ASSERT_TRUE(base);
  (*base)->SendGarbage({'h', 'e', 'l', 'l', 'o'});
  Outcome outcome = RunCheck(link);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("another device"));

  (*base)->SendGarbage({});
  (*base)->With([](Emulator& robot) { robot.SetSilent(true); });
  outcome = RunCheck(link);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("switch the base on"));

  outcome = RunCheck("/dev/no_such_port");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("no such device"));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);

  outcome = RunCheck("[1, 2]");
  EXPECT_EQ(outcome.exit_code, 78);
}

// The program over real multicast, on a port of its own.
class LiveProgramTest : public testing::Test {
 protected:
  void SetUp() override {
    url_ = "udpm://239.255.76.69:" + std::to_string(20000 + ::getpid() % 20000) + "?ttl=0";
    auto bus = process::LiveBus::Create(url_);
    if (!bus) GTEST_SKIP() << "no multicast on this host";
    bus_ = std::move(*bus);
    const auto subscribed = bus_->Subscribe(wire::kWheel, [this](auto message, Utime) {
      const auto sample = wire::Decode<WheelSample>(message);
      ASSERT_TRUE(sample);
      wheel_.push_back(*sample);
    });
    if (!subscribed) {
      bus_.reset();
      GTEST_SKIP() << "multicast does not come back on this host";
    }
    link_ = TempPath("port");
    config_path_ = WriteConfig(link_);
    auto base = PtyBase::Create({}, link_);
    ASSERT_TRUE(base);
    base_ = std::move(*base);
  }
  void TearDown() override {
    if (child_ > 0) Stop(SIGKILL);
    std::remove(config_path_.c_str());
  }

  void Start() {
    const std::string program = std::string(GW_BINARY_DIR) + "/gw-kobuki";
    child_ = ::fork();
    if (child_ == 0) {
      ::execl(program.c_str(), program.c_str(), "--config", config_path_.c_str(), "--lcm-url",
              url_.c_str(), nullptr);
      ::_exit(127);
    }
    ASSERT_GT(child_, 0);
  }
  int Stop(int signal) {
    int status = 0;
    ::kill(child_, signal);
    ::waitpid(child_, &status, 0);
    child_ = 0;
    return status;
  }
  // Sends commands until `done`.
  void DriveUntil(const std::function<bool()>& done) {
    while (!done()) {
      ASSERT_TRUE(bus_->Publish(wire::kBaseCommand,
                                wire::Encode(BaseCommand{clock_.Now(), ++seq_, 0.3, 0})));
      ASSERT_TRUE(bus_->Pump(20));
    }
  }
  double RobotSpeed() {
    double v = 0;
    base_->With([&](Emulator& robot) { v = robot.commanded().v_m_s; });
    return v;
  }

  process::Clock clock_;
  std::string url_, link_, config_path_;
  std::unique_ptr<process::LiveBus> bus_;
  std::unique_ptr<PtyBase> base_;
  std::vector<WheelSample> wheel_;
  pid_t child_ = 0;
  int64_t seq_ = 0;
};

TEST_F(LiveProgramTest, ObeysAndStopsTheBaseWhenItIsTold) {
  Start();
  DriveUntil([&] { return RobotSpeed() > 0.2 && wheel_.size() > 10; });
  const int status = Stop(SIGTERM);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  while (RobotSpeed() != 0) ::poll(nullptr, 0, 1);
}

TEST_F(LiveProgramTest, RestartAfterSigkillStopsTheBaseAndGoesOn) {
  Start();
  DriveUntil([&] { return RobotSpeed() > 0.2 && wheel_.size() > 10; });
  Stop(SIGKILL);
  EXPECT_GT(RobotSpeed(), 0.1);  // the firmware has no time-out that we know of
  Start();
  while (RobotSpeed() != 0) ::poll(nullptr, 0, 1);
  wheel_.clear();
  DriveUntil([&] { return RobotSpeed() > 0.2 && wheel_.size() > 10; });
}

}  // namespace
}  // namespace gw::kobuki

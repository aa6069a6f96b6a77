// gw-record as a process on a real bus at the robot's full load (stereo and depth at 30 Hz, IMU,
// wheels): what it wrote is what was sent, to the byte, and so is what lcm-logplayer makes of it.
// In real time: GW_RECORD_SECONDS of recording (default 10), and as long again for playing it.
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <map>
#include <memory>
#include <random>
#include <thread>

#include "common/process/bus.h"
#include "common/process/clock.h"
#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/data/import/test_folder.h"

namespace gw::record {
namespace {

namespace fs = std::filesystem;
using wire::Bytes;

// Multicast address in the private network that the test is started in
// (test/multiproc/in_private_network.py).
constexpr char kUrl[] = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304";

int64_t RecordSeconds() {
  const char* text = std::getenv("GW_RECORD_SECONDS");
  return text == nullptr ? 10 : std::atoll(text);
}

class Child {
 public:
  explicit Child(std::vector<std::string> command) {
    std::vector<char*> argv;
    argv.reserve(command.size() + 1);
    for (std::string& word : command) argv.push_back(word.data());
    argv.push_back(nullptr);
    if (::posix_spawnp(&pid_, argv[0], nullptr, nullptr, argv.data(), environ) != 0) pid_ = -1;
  }
  ~Child() {
    if (pid_ > 0 && !Ended()) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void Signal(int signal) const {
    if (pid_ > 0) ::kill(pid_, signal);
  }
  bool Ended() {
    if (pid_ > 0 && !ended_ && ::waitpid(pid_, &status_, WNOHANG) == pid_) ended_ = true;
    return pid_ <= 0 || ended_;
  }
  // Once it has ended: -1 when a signal did it, or when it was never there.
  int exit_code() const { return ended_ && WIFEXITED(status_) ? WEXITSTATUS(status_) : -1; }

 private:
  pid_t pid_ = -1;
  bool ended_ = false;
  int status_ = 0;
};

// What the robot's sensors say: any message can be made again from its time and number.
class Sensors {
 public:
  Sensors() {
    std::mt19937 random(1);
    for (uint8_t& byte : noise_) byte = static_cast<uint8_t>(random());
  }

  Bytes Message(const std::string& channel, Utime utime, int64_t seq) const {
    if (channel == wire::kImu) {
      ImuSample sample;
      sample.utime = utime;
      sample.seq = seq;
      sample.has_accel = true;
      sample.a_I_m_s2 = {0.001 * static_cast<double>(seq % 100), 0, 9.81};
      return wire::Encode(sample);
    }
    if (channel == wire::kWheel) {
      WheelSample sample;
      sample.utime = utime;
      sample.utime_begin = utime - Milliseconds(20);
      sample.seq = seq;
      sample.dx_m = 0.01;
      return wire::Encode(sample);
    }
    // Neighbouring images differ in every pixel.
    const uint8_t* pixels = &noise_[static_cast<size_t>(seq % 1000) * 2];
    CameraFrame frame;
    frame.utime = utime;
    frame.seq = seq;
    frame.left = {pixels, kWidth, kHeight, kWidth, PixelFormat::kGray8};
    frame.right = {pixels + 2000, kWidth, kHeight, kWidth, PixelFormat::kGray8};
    frame.depth = {pixels + 4000, kWidth, kHeight, 2 * kWidth, PixelFormat::kDepth16};
    return wire::Encode(frame);
  }

 private:
  static constexpr int kWidth = 640, kHeight = 480;
  std::vector<uint8_t> noise_ = std::vector<uint8_t>(2 * kWidth * kHeight + 6000);
};

const std::vector<std::string> kChannels = {wire::kCamera, wire::kImu, wire::kWheel};
using Counts = std::map<std::string, int64_t>;

// Counts messages that come in order, without a gap and as they were sent.
class Check {
 public:
  explicit Check(const Sensors* sensors) : sensors_(sensors) {}

  void Take(const std::string& channel, std::span<const uint8_t> message) {
    const auto header = wire::ReadHeader(message);
    if (!header || header->seq != good_[channel] + 1) return;
    const Bytes sent = sensors_->Message(channel, header->utime, header->seq);
    if (std::equal(sent.begin(), sent.end(), message.begin(), message.end())) ++good_[channel];
  }
  const Counts& good() const { return good_; }

 private:
  const Sensors* sensors_;
  Counts good_;
};

class RecordLiveTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto bus = process::LiveBus::Create(kUrl);
    if (!bus) GTEST_SKIP() << bus.error().message;
    bus_ = std::move(*bus);
    if (!bus_->warning().empty()) GTEST_SKIP() << bus_->warning();
    ASSERT_TRUE(bus_->Subscribe(wire::kHealth, [this](auto, Utime) { recorder_is_up_ = true; }));
  }

  // A step of the bus every 5 ms: IMU at 200 Hz, wheels at 50 Hz, the camera at 30 Hz.
  Counts SendFor(int64_t seconds) {
    Counts sent;
    const auto begin = std::chrono::steady_clock::now();
    for (int64_t step = 0; step < seconds * 200; ++step) {
      std::this_thread::sleep_until(begin + std::chrono::milliseconds(5 * step));
      Send(wire::kImu, sent);
      if (step % 4 == 0) Send(wire::kWheel, sent);
      if (step * 30 / 200 != (step - 1) * 30 / 200 || step == 0) Send(wire::kCamera, sent);
    }
    return sent;
  }

  void Send(const std::string& channel, Counts& sent) {
    const Bytes message = sensors_.Message(channel, clock_.Now(), ++sent[channel]);
    ASSERT_TRUE(bus_->Publish(channel, message));
  }

  // Handles what comes until the child has ended and the bus is quiet.
  void PumpUntilEnded(Child& child) {
    while (!child.Ended()) ASSERT_TRUE(bus_->Pump(100));
    for (auto handled = bus_->Pump(500); handled && *handled > 0;) handled = bus_->Pump(500);
  }

  Sensors sensors_;
  process::Clock clock_;
  std::unique_ptr<process::LiveBus> bus_;
  bool recorder_is_up_ = false;
};

TEST_F(RecordLiveTest, RecordsAllThatIsSentAndReplaysIt) {
  const importer::TestFolder folder;
  const int64_t seconds = RecordSeconds();
  // 1.23 MB an image, a quarter of the allowance for evidence, and some more.
  const std::string max_gb = std::to_string(1 + seconds * 6 / 100);
  const std::string program = std::string(GW_BINARY_DIR) + "/gw-record";
  const std::string config = std::string(GW_SOURCE_DIR) + "/config/robots/turtlebot2_d435i.yaml";
  Child recorder({program, "--config", config, "--lcm-url", kUrl, "--out", folder.path().string(),
                  "--max-gb", max_gb});
  while (!recorder_is_up_ && !recorder.Ended()) ASSERT_TRUE(bus_->Pump(100));
  ASSERT_FALSE(recorder.Ended());

  const Counts sent = SendFor(seconds);
  std::this_thread::sleep_for(std::chrono::seconds(2));  // the last messages are on their way
  recorder.Signal(SIGTERM);
  PumpUntilEnded(recorder);
  EXPECT_EQ(recorder.exit_code(), 0);

  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    if (entry.path().extension() == ".lcm") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  Check recorded(&sensors_);
  for (const fs::path& file : files) {
    auto log = process::EventLogReader::Open(file.string());
    ASSERT_TRUE(log);
    while (const auto event = log->Next()) {
      const std::string channel(event->channel);
      if (sent.contains(channel)) recorded.Take(channel, event->data);
    }
  }
  EXPECT_EQ(recorded.good(), sent);

  Check replayed(&sensors_);
  for (const std::string& channel : kChannels) {
    ASSERT_TRUE(bus_->Subscribe(
        channel, [&replayed, channel](auto message, Utime) { replayed.Take(channel, message); }));
  }
  for (const fs::path& file : files) {
    Child player({"lcm-logplayer", std::string("--lcm-url=") + kUrl, file.string()});
    PumpUntilEnded(player);
    ASSERT_EQ(player.exit_code(), 0) << "lcm-logplayer (package liblcm-bin)";
  }
  EXPECT_EQ(replayed.good(), sent);
  for (const auto& [channel, count] : sent) {
    std::cout << channel << ": sent " << count << ", recorded " << recorded.good().at(channel)
              << ", replayed " << replayed.good().at(channel) << "\n";
  }
}

}  // namespace
}  // namespace gw::record

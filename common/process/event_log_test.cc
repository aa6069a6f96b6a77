#include "common/process/event_log.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/core/random.h"

namespace gw::process {
namespace {

using Bytes = std::vector<uint8_t>;

struct OwnedEvent {
  int64_t number;
  int64_t received_us;
  std::string channel;
  Bytes data;
  bool operator==(const OwnedEvent&) const = default;
};

class EventLog : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ = std::filesystem::path(::testing::TempDir()) /
                 ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  std::string Path(const std::string& name) const { return directory_ / name; }

  static std::vector<OwnedEvent> RandomEvents(uint64_t seed, int count, uint32_t max_size) {
    std::vector<OwnedEvent> events;
    for (int i = 0; i < count; ++i) {
      CounterRng rng(seed, 0, i);
      OwnedEvent event{i, 1'600'000'000'000'000 + i * 1000, rng.Below(2) == 0 ? "CAMERA" : "IMU",
                       Bytes(rng.Below(max_size + 1))};
      for (uint8_t& byte : event.data) byte = static_cast<uint8_t>(rng.NextU64());
      events.push_back(std::move(event));
    }
    return events;
  }

  std::string Write(const std::string& name, const std::vector<OwnedEvent>& events) {
    auto writer = EventLogWriter::Create(Path(name));
    EXPECT_TRUE(writer.ok());
    for (const OwnedEvent& event : events) {
      EXPECT_TRUE(writer->Append(Utime{event.received_us}, event.channel, event.data).ok());
    }
    EXPECT_TRUE(writer->Close().ok());
    EXPECT_EQ(static_cast<int64_t>(std::filesystem::file_size(Path(name))),
              writer->bytes_written());
    return Path(name);
  }

  static std::vector<OwnedEvent> ReadAll(EventLogReader& reader) {
    std::vector<OwnedEvent> events;
    while (const auto event = reader.Next()) {
      events.push_back({event->number, event->received.us, std::string(event->channel),
                        Bytes(event->data.begin(), event->data.end())});
    }
    return events;
  }

  static std::string Slurp(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::string Spill(const std::string& name, const std::string& bytes) const {
    std::ofstream(Path(name), std::ios::binary) << bytes;
    return Path(name);
  }

  std::filesystem::path directory_;
};

TEST_F(EventLog, GivesBackWhatWasWrittenInOrder) {
  for (const uint32_t max_size : {0u, 100u, 300'000u, 6'000'000u}) {
    const auto events = RandomEvents(max_size, max_size > 100'000 ? 12 : 500, max_size);
    auto reader = EventLogReader::Open(Write("log", events));
    ASSERT_TRUE(reader.ok());
    EXPECT_EQ(ReadAll(*reader), events);
    EXPECT_EQ(reader->skipped_bytes(), 0);
    EXPECT_FALSE(reader->truncated());
    EXPECT_FALSE(reader->error());
    EXPECT_EQ(reader->position(), reader->size());
  }
}

TEST_F(EventLog, HasTheBytesOfLcmLogger) {
  const std::string bytes = Slurp(Write("log", {{0, 0x000660D3C3C93BC1, "IMG0", {0xFD, 0x7F}}}));
  const uint8_t expected[] = {0xED, 0xA1, 0xDA, 0x01, 0,    0,    0,    0,    0,    0,
                              0,    0,    0x00, 0x06, 0x60, 0xD3, 0xC3, 0xC9, 0x3B, 0xC1,  //
                              0,    0,    0,    4,    0,    0,    0,    2,    'I',  'M',
                              'G',  '0',  0xFD, 0x7F};
  EXPECT_EQ(bytes, std::string(std::begin(expected), std::end(expected)));
}

TEST_F(EventLog, SameEventsGiveTheSameBytes) {
  const auto events = RandomEvents(7, 300, 20'000);
  EXPECT_EQ(Slurp(Write("a", events)), Slurp(Write("b", events)));
}

TEST_F(EventLog, IsEmptyWhenTheFileIs) {
  auto reader = EventLogReader::Open(Spill("log", ""));
  ASSERT_TRUE(reader.ok());
  EXPECT_FALSE(reader->Next());
  EXPECT_FALSE(reader->truncated());
}

TEST_F(EventLog, EndsAtATruncatedEventAndSaysSo) {
  const auto events = RandomEvents(3, 3, 200);
  const std::string whole = Slurp(Write("log", events));
  const size_t last = 28 + events[2].channel.size() + events[2].data.size();
  for (size_t cut = 1; cut <= last; ++cut) {
    auto reader = EventLogReader::Open(Spill("cut", whole.substr(0, whole.size() - cut)));
    ASSERT_TRUE(reader.ok());
    const auto found = ReadAll(*reader);
    ASSERT_EQ(found.size(), 2u) << cut;
    EXPECT_EQ(found[1], events[1]);
    EXPECT_EQ(reader->truncated(), cut < last) << cut;
    EXPECT_EQ(reader->skipped_bytes(), 0) << cut;
  }
}

TEST_F(EventLog, SkipsGarbageAndCountsIt) {
  const auto events = RandomEvents(4, 6, 200);
  std::string bytes;
  int64_t garbage = 0;
  for (int i = 0; i < 6; ++i) {
    CounterRng rng(5, 0, i);
    std::string junk;
    for (uint32_t k = rng.Below(300) + 1; k > 0; --k)
      junk.push_back(static_cast<char>(rng.Below(256)));
    if (i % 2 == 0) junk += "\xED\xA1\xDA\x01 not an event, though it begins like one";
    bytes += junk;
    garbage += static_cast<int64_t>(junk.size());
    std::vector<OwnedEvent> one = {events[i]};
    const std::string event = Slurp(Write("one", one));
    bytes += event.substr(0, 4) + std::string(7, '\0') + static_cast<char>(i) + event.substr(12);
  }
  auto reader = EventLogReader::Open(Spill("log", bytes));
  ASSERT_TRUE(reader.ok());
  EXPECT_EQ(ReadAll(*reader), events);
  EXPECT_EQ(reader->skipped_bytes(), garbage);
  EXPECT_FALSE(reader->truncated());
}

TEST_F(EventLog, AWrongLengthCostsOnlyItsOwnEvent) {
  const auto events = RandomEvents(6, 5, 400);
  const std::string whole = Slurp(Write("log", events));
  const size_t second = 28 + events[0].channel.size() + events[0].data.size();
  // Longer (reaching into the events behind it, and past the end of the file) and shorter.
  for (const uint32_t length : {600u, 1'000'000u, 0x0FFFFFFFu, 0xFFFFFFFFu, 1u}) {
    std::string broken = whole;
    for (int i = 0; i < 4; ++i) broken[second + 24 + i] = static_cast<char>(length >> (24 - 8 * i));
    auto reader = EventLogReader::Open(Spill("broken", broken));
    ASSERT_TRUE(reader.ok());
    auto found = ReadAll(*reader);
    std::erase_if(found, [](const OwnedEvent& event) { return event.number == 1; });
    ASSERT_EQ(found.size(), 4u) << length;
    EXPECT_EQ(found[1], events[2]);
    EXPECT_EQ(found[3], events[4]);
    EXPECT_GT(reader->skipped_bytes(), 0);
  }
}

TEST_F(EventLog, SurvivesAnyDamage) {
  const std::string whole = Slurp(Write("log", RandomEvents(8, 20, 300)));
  for (int i = 0; i < 300; ++i) {
    CounterRng rng(9, 0, i);
    std::string broken = whole;
    for (uint32_t k = rng.Below(20) + 1; k > 0; --k) {
      broken[rng.Below(static_cast<uint32_t>(broken.size()))] = static_cast<char>(rng.Below(256));
    }
    broken.resize(rng.Below(static_cast<uint32_t>(broken.size())) + 1);
    auto reader = EventLogReader::Open(Spill("broken", broken));
    ASSERT_TRUE(reader.ok());
    EXPECT_LE(ReadAll(*reader).size(), 40u);
    EXPECT_FALSE(reader->error());
    EXPECT_LE(reader->skipped_bytes(), reader->size());
  }
}

TEST_F(EventLog, FullDiskIsAnErrorWithPathAndReason) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
  auto writer = EventLogWriter::Create("/dev/full");
  ASSERT_TRUE(writer.ok());
  const Bytes image(700'000);
  Result<Done> result = Done{};
  for (int i = 0; i < 4 && result.ok(); ++i) result = writer->Append(Utime{i}, "CAMERA", image);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::kIo);
  EXPECT_EQ(result.error().message, "cannot write /dev/full: No space left on device");
  EXPECT_FALSE(writer->Append(Utime{9}, "IMU", {}).ok());  // and stays one
  EXPECT_FALSE(writer->Close().ok());
}

TEST_F(EventLog, SmallWritesToAFullDiskFailAtCloseAtTheLatest) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
  auto writer = EventLogWriter::Create("/dev/full");
  ASSERT_TRUE(writer.ok());
  EXPECT_TRUE(writer->Append(Utime{1}, "IMU", Bytes(10)).ok());
  EXPECT_FALSE(writer->Close().ok());
}

TEST_F(EventLog, RefusesWhatLcmCannotCarry) {
  auto writer = EventLogWriter::Create(Path("log"));
  ASSERT_TRUE(writer.ok());
  EXPECT_FALSE(writer->Append(Utime{1}, "", {}).ok());
  EXPECT_FALSE(writer->Append(Utime{1}, std::string(64, 'A'), {}).ok());
  EXPECT_TRUE(writer->Append(Utime{1}, std::string(63, 'A'), {}).ok());
  EXPECT_TRUE(writer->Close().ok());
}

TEST_F(EventLog, MissingFilesAndDirectoriesAreErrors) {
  const auto missing = EventLogReader::Open(Path("absent.lcm"));
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_NE(missing.error().message.find("absent.lcm"), std::string::npos);
  EXPECT_FALSE(EventLogReader::Open(directory_).ok());
  EXPECT_FALSE(EventLogWriter::Create(Path("no/such/folder.lcm")).ok());
}

}  // namespace
}  // namespace gw::process

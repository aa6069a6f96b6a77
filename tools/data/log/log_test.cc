#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/data/log/cut.h"
#include "tools/data/log/inspect.h"
#include "tools/data/log/log_clock.h"
#include "tools/data/log/safe_log_writer.h"
#include "tools/data/log/span.h"

namespace gw::tools {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(LogClock, JoinedLogsFollowEachOther) {
  LogClock clock;
  EXPECT_EQ(clock.Add({5000000}).us, 0);
  EXPECT_EQ(clock.Add({8000000}).us, 3000000);
  EXPECT_EQ(clock.Add({7500000}).us, 2500000);  // disorder of half a second is no new piece
  EXPECT_EQ(clock.Add({8000000}).us, 3000000);
  EXPECT_THAT(clock.steps(), IsEmpty());
  EXPECT_EQ(clock.Add({1000000}).us, 3000000);  // another log begins
  EXPECT_EQ(clock.Add({2000000}).us, 4000000);
  EXPECT_EQ(clock.Add({3602000000}).us, 3604000000);  // an hour ahead
  ASSERT_EQ(clock.steps().size(), 2u);
  EXPECT_EQ(clock.steps()[0].index, 4);
  EXPECT_EQ(clock.steps()[0].by().us, -7000000);
  EXPECT_THAT(Describe(clock.steps()[0]), HasSubstr("goes back by 7.000 s at event 4"));
  EXPECT_THAT(Describe(clock.steps()[1]), HasSubstr("jumps ahead by 3600.000 s at event 6"));
  EXPECT_EQ(clock.length().us, 3604000000);
}

class LogTest : public testing::Test {
 protected:
  LogTest() {
    std::string name = (fs::temp_directory_path() / "gw_log_test_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = name;
  }
  ~LogTest() override { fs::remove_all(folder_); }
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  // 100 IMU samples at 100 Hz, a note at the begin, one in the middle; `edit` changes or drops.
  std::string WriteLog(const std::function<bool(ImuSample&)>& edit = [](ImuSample&) {
    return true;
  }) const {
    const std::string file = Path("a.lcm");
    auto writer = process::EventLogWriter::Create(file);
    EXPECT_TRUE(writer);
    wire::Note note;
    note.utime = {1000000};
    note.seq = 1;
    note.key = "source";
    note.text = "a \"test\"";
    EXPECT_TRUE(writer->Append(note.utime, wire::kNote, wire::Encode(note)));
    for (int i = 0; i < 100; ++i) {
      ImuSample sample;
      sample.utime = {1000000 + i * 10000};
      sample.seq = i + 1;
      const Utime received = sample.utime;
      if (i == 50) {
        note.utime = received;
        note.seq = 2;
        note.key = "middle";
        EXPECT_TRUE(writer->Append(received, wire::kNote, wire::Encode(note)));
      }
      if (edit(sample)) {
        EXPECT_TRUE(writer->Append(received, wire::kImu, wire::Encode(sample)));
      }
    }
    EXPECT_TRUE(writer->Close());
    return file;
  }
  LogReport Check(const std::string& file) const {
    auto report = InspectLog(file, InspectDepth::kDecode);
    EXPECT_TRUE(report);
    return *report;
  }

 private:
  fs::path folder_;
};

// cat a.lcm a.lcm: both halves are counted, the seam is named once, and a cut can take either.
TEST_F(LogTest, AJoinedLogIsReadWholeAndNamed) {
  const std::string file = WriteLog();
  std::stringstream bytes;
  bytes << std::ifstream(file, std::ios::binary).rdbuf();
  const std::string joined = Path("joined.lcm");
  std::ofstream(joined, std::ios::binary) << bytes.str() << bytes.str();
  // The halves are 0.99 s long: too short a step back to be a seam; the second begins 5 s earlier.
  const std::string early = Path("early.lcm");
  {
    auto writer = process::EventLogWriter::Create(early);
    ASSERT_TRUE(writer);
    for (int pass = 0; pass < 2; ++pass) {
      auto half = process::EventLogReader::Open(file);
      while (const auto event = half->Next()) {
        const Utime received = event->received - DurationUs{pass * 5000000};
        ASSERT_TRUE(writer->Append(received, event->channel, event->data));
      }
    }
    ASSERT_TRUE(writer->Close());
  }
  const LogReport report = Check(early);
  EXPECT_FALSE(report.ok);
  EXPECT_EQ(report.events, 204);
  EXPECT_EQ(report.channels.at(wire::kImu).messages, 200);
  EXPECT_EQ(report.receive_time_faults, 1);
  ASSERT_EQ(report.time_steps.size(), 1u);
  EXPECT_EQ(report.time_steps[0].index, 102);
  EXPECT_THAT(ReportText(report), HasSubstr("time goes back by 5.990 s at event 102"));
  EXPECT_THAT(ReportJson(report), HasSubstr("\"time_steps\":[{\"event\":102,"));
  EXPECT_NEAR(report.length.seconds(), 1.98, 1e-9);

  const std::string second = Path("second.lcm");
  ASSERT_TRUE(CutLog(early, {{1000000}, Span().end}, second));
  EXPECT_EQ(Check(second).channels.at(wire::kImu).messages, 99);  // 0.01 to 0.99 s of the second
  EXPECT_EQ(Check(joined).channels.at(wire::kImu).messages, 200);
}

TEST_F(LogTest, AGoodLogIsOkAndDescribed) {
  const LogReport report = Check(WriteLog());
  EXPECT_TRUE(report.ok);
  EXPECT_THAT(report.problems, IsEmpty());
  EXPECT_EQ(report.events, 102);
  EXPECT_EQ(report.begin.us, 1000000);
  EXPECT_EQ((report.end - report.begin).us, 990000);
  const ChannelReport& imu = report.channels.at("IMU");
  EXPECT_EQ(imu.messages, 100);
  EXPECT_NEAR(imu.rate_hz(), 100, 1e-9);
  EXPECT_EQ(imu.largest_gap.us, 10000);
  ASSERT_EQ(report.notes.size(), 2u);
  EXPECT_EQ(report.notes[1].key, "middle");
  EXPECT_THAT(ReportText(report), HasSubstr("source: a \"test\""));
  EXPECT_THAT(ReportJson(report), HasSubstr("\"text\":\"a \\\"test\\\"\""));
}

TEST_F(LogTest, LostMessagesAreCounted) {
  const LogReport report = Check(WriteLog([](ImuSample& s) { return s.seq < 20 || s.seq > 24; }));
  EXPECT_FALSE(report.ok);
  EXPECT_EQ(report.channels.at("IMU").lost, 5);
  EXPECT_EQ(report.channels.at("IMU").largest_gap.us, 60000);
  EXPECT_EQ(report.channels.at("IMU").largest_gap_begin.us, 1180000);
  EXPECT_THAT(report.problems, ElementsAre(HasSubstr("5 messages lost between seq 19 and 25")));
}

TEST_F(LogTest, ARestartedSenderIsNoFault) {
  const LogReport report = Check(WriteLog([](ImuSample& s) {
    if (s.seq > 50) s.seq -= 50;
    return true;
  }));
  EXPECT_TRUE(report.ok);
  EXPECT_EQ(report.channels.at("IMU").restarts, 1);
}

TEST_F(LogTest, RepeatedAndBackwardSequencesAndTimesAreFaults) {
  LogReport report = Check(WriteLog([](ImuSample& s) {
    if (s.seq == 50) s.seq = 49;
    return true;
  }));
  EXPECT_FALSE(report.ok);
  EXPECT_EQ(report.channels.at("IMU").sequence_faults, 1);
  report = Check(WriteLog([](ImuSample& s) {
    if (s.seq == 50) s.utime = s.utime - DurationUs{10000};
    return true;
  }));
  EXPECT_FALSE(report.ok);
  EXPECT_EQ(report.channels.at("IMU").time_faults, 1);
  EXPECT_THAT(report.problems, ElementsAre(HasSubstr("repeats the utime")));
  report = Check(WriteLog([](ImuSample& s) {
    if (s.seq == 50) s.utime = s.utime - DurationUs{10001};
    return true;
  }));
  EXPECT_THAT(report.problems, ElementsAre(HasSubstr("utime is 1 us before")));
}

TEST_F(LogTest, UndecodableMessagesAreNamed) {
  const LogReport report = Check(WriteLog([](ImuSample& s) {
    if (s.seq == 50) s.w_I_rad_s.x() = std::numeric_limits<double>::quiet_NaN();
    return true;
  }));
  EXPECT_FALSE(report.ok);
  EXPECT_EQ(report.channels.at("IMU").undecodable, 1);
  EXPECT_EQ(report.channels.at("IMU").lost, 0);  // it came, though broken
  EXPECT_THAT(ReportText(report), HasSubstr("problem: IMU: event 50: imu_t message refused"));
}

TEST_F(LogTest, ManyProblemsOfAKindAreSummarised) {
  const LogReport report = Check(WriteLog([](ImuSample& s) { return s.seq % 2 == 0; }));
  EXPECT_EQ(report.channels.at("IMU").lost, 49);
  ASSERT_EQ(report.problems.size(), kMaxProblemsPerKind + 1u);
  EXPECT_THAT(report.problems.back(), HasSubstr("lost: 44 more"));
}

TEST_F(LogTest, TruncationAtEveryByteOfTheLastEventIsReported) {
  const std::string file = WriteLog();
  const auto whole = fs::file_size(file);
  const LogReport good = Check(file);
  const auto event_bytes = static_cast<uintmax_t>(28 + 3 + good.channels.at("IMU").bytes / 100);
  for (uintmax_t cut = 1; cut < event_bytes; ++cut) {
    fs::resize_file(file, whole - cut);
    const LogReport report = Check(file);
    ASSERT_FALSE(report.ok) << cut;
    ASSERT_TRUE(report.truncated || report.skipped_bytes > 0) << cut;
    ASSERT_EQ(report.channels.at("IMU").messages, 99) << cut;
  }
}

TEST_F(LogTest, GarbageIsSkippedAndReported) {
  const std::string file = WriteLog();
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekp(5000);
  stream << "this is not an event";
  stream.close();
  const LogReport report = Check(file);
  EXPECT_FALSE(report.ok);
  EXPECT_GE(report.channels.at("IMU").messages, 98);
}

TEST_F(LogTest, ForeignFilesAreRefused) {
  EXPECT_EQ(InspectLog(Path("none"), InspectDepth::kHeaders).error().code, ErrorCode::kNotFound);
  std::ofstream(Path("text")) << "hello";
  const auto report = InspectLog(Path("text"), InspectDepth::kHeaders);
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message, HasSubstr("is it an LCM log?"));
}

TEST_F(LogTest, UnknownChannelsAreCountedButNoFault) {
  {
    auto writer = process::EventLogWriter::Create(Path("b.lcm"));
    ASSERT_TRUE(writer);
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(writer->Append({i * 1000}, "OTHER", std::vector<uint8_t>{1, 2, 3}));
    }
    ASSERT_TRUE(writer->Close());
  }
  const LogReport report = Check(Path("b.lcm"));
  EXPECT_TRUE(report.ok);
  EXPECT_FALSE(report.channels.at("OTHER").known);
  EXPECT_EQ(report.channels.at("OTHER").messages, 3);
}

// Reliable messages may be sent again; only what never came is lost.
TEST_F(LogTest, ResentReliableMessagesAreNoFault) {
  auto writer = process::EventLogWriter::Create(Path("b.lcm"));
  ASSERT_TRUE(writer);
  for (const int64_t seq : {1, 2, 2, 4, 3, 7}) {
    Keyframe keyframe;
    keyframe.id = {seq};
    keyframe.utime = {seq * 1000};
    wire::Bytes message = wire::Encode(keyframe);
    wire::SetDelivery({seq, 99, 1}, message);
    ASSERT_TRUE(writer->Append({1000}, wire::kKeyframe, message));
  }
  ASSERT_TRUE(writer->Close());
  const auto report = InspectLog(Path("b.lcm"), InspectDepth::kHeaders);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->channels.at("KEYFRAME").lost, 2);
  EXPECT_THAT(report->problems, ElementsAre(HasSubstr("2 messages of one session never came")));
}

TEST_F(LogTest, CutKeepsTheSpanAndAllNotesBefore) {
  const auto cut = CutLog(WriteLog(), {{200000}, {700000}}, Path("c.lcm"));
  ASSERT_TRUE(cut) << cut.error().message;
  const LogReport report = Check(Path("c.lcm"));
  EXPECT_TRUE(report.ok);
  EXPECT_EQ(report.events, cut->events);
  EXPECT_EQ(report.file_bytes, cut->bytes);
  EXPECT_EQ(report.begin.us, 1200000);
  EXPECT_EQ(report.channels.at("IMU").messages, 50);
  EXPECT_EQ(report.channels.at("IMU").last.us, 1690000);
  ASSERT_EQ(report.notes.size(), 3u);
  EXPECT_EQ(report.notes[0].key, "source");
  EXPECT_EQ(report.notes[1].key, "edit.cut");
  EXPECT_EQ(report.notes[2].key, "middle");
}

TEST_F(LogTest, CutToTheWholeSpanKeepsEveryMessageAsItWas) {
  const std::string file = WriteLog();
  ASSERT_TRUE(CutLog(file, {}, Path("c.lcm")));
  auto a = process::EventLogReader::Open(file);
  auto b = process::EventLogReader::Open(Path("c.lcm"));
  ASSERT_TRUE(a && b);
  int same = 0;
  while (const auto event = a->Next()) {
    if (event->channel == wire::kNote) continue;
    auto other = b->Next();
    while (other && other->channel == wire::kNote) other = b->Next();
    ASSERT_TRUE(other);
    ASSERT_TRUE(
        std::equal(event->data.begin(), event->data.end(), other->data.begin(), other->data.end()));
    ++same;
  }
  EXPECT_EQ(same, 100);
}

TEST_F(LogTest, CutWorksWithATruncatedLog) {
  const std::string file = WriteLog();
  fs::resize_file(file, fs::file_size(file) - 10);
  const auto cut = CutLog(file, {{500000}, {10000000}}, Path("c.lcm"));
  ASSERT_TRUE(cut);
  EXPECT_TRUE(cut->source_truncated);
  EXPECT_TRUE(Check(Path("c.lcm")).ok);
}

TEST_F(LogTest, CutLeavesNothingBehindWhenItFails) {
  const std::string file = WriteLog();
  std::ofstream(Path("c.lcm")) << "old";
  EXPECT_FALSE(CutLog(file, {{50000000}, {60000000}}, Path("c.lcm")));
  EXPECT_FALSE(fs::exists(Path("c.lcm.partial")));
  EXPECT_EQ(fs::file_size(Path("c.lcm")), 3u);
  EXPECT_EQ(CutLog(file, {{0}, {1000000}}, file).error().code, ErrorCode::kInvalidArgument);
  EXPECT_FALSE(CutLog(file, {{0}, {1000000}}, Path("no/such/folder/c.lcm")));
}

TEST(Span, ParsesTimesAndValues) {
  const auto open = ParseSpan("--x", ":");
  ASSERT_TRUE(open);
  EXPECT_TRUE(open->span.Contains({0}));
  EXPECT_TRUE(open->span.Contains({1'000'000'000'000}));
  EXPECT_EQ(ParseSpan("--x", "0.2:0.7")->span.begin.us, 200000);
  const auto span = ParseSpan("--x", "1.5:2:0.25", 0, 1);
  ASSERT_TRUE(span);
  EXPECT_FALSE(span->span.Contains({1499999}));
  EXPECT_TRUE(span->span.Contains({1500000}));
  EXPECT_FALSE(span->span.Contains({2000000}));
  EXPECT_THAT(span->values, ElementsAre(0.25));
  for (const char* bad :
       {"", "1", "2:1", "1:1", "a:2", "1:2:3:4", "-1:2", "1:nan", "1:2:", "1s:2"}) {
    const auto result = ParseSpan("--x", bad, 0, 1);
    ASSERT_FALSE(result) << bad;
    EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(result.error().message, HasSubstr("--x"));
  }
  EXPECT_FALSE(ParseSpan("--x", "1:2", 1, 1));
}

}  // namespace
}  // namespace gw::tools

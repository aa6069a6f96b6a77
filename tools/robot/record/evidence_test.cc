#include "tools/robot/record/evidence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tools/data/import/test_folder.h"

namespace gw::record {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr Utime kStart{1'764'101'283'000'000};
Utime At(double s) {
  return kStart + DurationFromSeconds(s);
}

Health Report(const std::string& process, HealthState state, const std::string& message = "") {
  Health health;
  health.process = process;
  health.state = state;
  health.message = message;
  health.counters = {{"CAMERA.lost", 3}};
  return health;
}

TEST(FaultWatch, TellsWhenAProcessGetsWorseAndOnlyThen) {
  FaultWatch watch;
  EXPECT_FALSE(watch.Observe(Report("gw-frontend", HealthState::kStarting), At(0)));
  EXPECT_FALSE(watch.Observe(Report("gw-frontend", HealthState::kOk), At(1)));
  const auto fault =
      watch.Observe(Report("gw-frontend", HealthState::kDegraded, "camera is dark"), At(2));
  ASSERT_TRUE(fault);
  EXPECT_THAT(*fault, HasSubstr("gw-frontend: OK to DEGRADED: camera is dark"));
  EXPECT_THAT(*fault, HasSubstr("CAMERA.lost 3"));
  EXPECT_FALSE(watch.Observe(Report("gw-frontend", HealthState::kDegraded), At(3)));  // still
  EXPECT_TRUE(watch.Observe(Report("gw-frontend", HealthState::kFailed), At(4)));     // worse
  EXPECT_FALSE(watch.Observe(Report("gw-frontend", HealthState::kDegraded), At(5)));  // better
  EXPECT_FALSE(watch.Observe(Report("gw-frontend", HealthState::kOk), At(6)));
  EXPECT_TRUE(watch.Observe(Report("gw-frontend", HealthState::kDegraded), At(7)));
}

TEST(FaultWatch, AProcessThatStartsUnwellIsNoNewFault) {
  FaultWatch watch;
  EXPECT_FALSE(watch.Observe(Report("gw-kobuki", HealthState::kFailed), At(0)));
}

TEST(FaultWatch, TellsOnceThatAProcessFellSilent) {
  FaultWatch watch;
  watch.Observe(Report("gw-backend", HealthState::kOk), At(0));
  EXPECT_FALSE(watch.CheckSilence(At(2.9)));
  const auto fault = watch.CheckSilence(At(3));
  ASSERT_TRUE(fault);
  EXPECT_EQ(*fault, "gw-backend: no HEALTH for 3000 ms\n");
  EXPECT_FALSE(watch.CheckSilence(At(9)));
  watch.Observe(Report("gw-backend", HealthState::kOk), At(10));
  EXPECT_TRUE(watch.CheckSilence(At(13)));
}

class Evidence : public testing::Test {
 protected:
  Evidence() {
    fs::create_directory(folder_.path() / "log");
    log_.emplace(
        *SegmentLog::Open(folder_.path() / "log", {.segment_bytes = 5000, .total_bytes = 1 << 20}));
  }
  // A message of 1034 bytes each tenth of a second: a file is half a second.
  void Record(double from, double to) {
    for (double t = from; t < to - 1e-9; t += 0.1) {
      ASSERT_TRUE(log_->Append(At(t), "CAMERA", std::vector<uint8_t>(1000)));
    }
  }
  static std::string Read(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }

  importer::TestFolder folder_;
  std::optional<SegmentLog> log_;
  const fs::path events_ = folder_.path() / "events";
};

TEST_F(Evidence, KeepsTheHalfMinuteBeforeAndTheSecondsAfter) {
  EvidenceKeeper keeper(events_, "robot: {name: x}\n", 1 << 20);
  Record(0, 60);
  EXPECT_TRUE(keeper.Begin("gw-frontend: dark\n", At(60)));
  EXPECT_FALSE(keeper.Begin("gw-backend: late\n", At(61)));  // the same fault
  Record(60, 65);
  auto kept = keeper.KeepIfDue(*log_, "map revision 7\n", At(64.9));
  ASSERT_TRUE(kept);
  EXPECT_FALSE(*kept);
  kept = keeper.KeepIfDue(*log_, "map revision 7\n", At(65));
  ASSERT_TRUE(kept) << kept.error().message;
  ASSERT_TRUE(*kept);
  EXPECT_EQ((*kept)->filename(), "2025-11-25T20-09-03.000000-gw-frontend");
  EXPECT_EQ(Read(**kept / "fault.txt"), "gw-frontend: dark\ngw-backend: late\nmap revision 7\n");
  EXPECT_EQ(Read(**kept / "robot.yaml"), "robot: {name: x}\n");

  fs::remove_all(folder_.path() / "log");  // evidence outlives the log
  Utime first{INT64_MAX}, last{};
  for (const auto& entry : fs::directory_iterator(**kept)) {
    if (entry.path().extension() != ".lcm") continue;
    auto reader = process::EventLogReader::Open(entry.path().string());
    ASSERT_TRUE(reader);
    while (const auto event = reader->Next()) {
      first = std::min(first, event->received);
      last = std::max(last, event->received);
    }
  }
  EXPECT_LE(first, At(30));
  EXPECT_GT(first, At(29));
  EXPECT_GT(last, At(64.8));
}

TEST_F(Evidence, FaultsInARowAreOne) {
  EvidenceKeeper keeper(events_, "", 1 << 20);
  Record(0, 1);
  EXPECT_TRUE(keeper.Begin("a: x\n", At(1)));
  EXPECT_TRUE(keeper.KeepIfDue(*log_, "", At(6))->has_value());
  EXPECT_FALSE(keeper.Begin("a: x\n", At(60)));
  EXPECT_FALSE(keeper.KeepIfDue(*log_, "", At(70))->has_value());
  EXPECT_TRUE(keeper.Begin("a: x\n", At(61)));
}

TEST_F(Evidence, TheOldestGoesWhenItIsTooMuch) {
  EvidenceKeeper keeper(events_, "", 12000);
  for (int i = 0; i < 4; ++i) {
    const double t = 100.0 * i;
    Record(t, t + 1);
    ASSERT_TRUE(keeper.Begin("p: x\n", At(t + 1)));
    ASSERT_TRUE(keeper.KeepIfDue(*log_, "", At(t + 6)));
  }
  EXPECT_FALSE(fs::exists(events_ / "2025-11-25T20-08-04.000000-p"));
  EXPECT_TRUE(fs::exists(events_ / "2025-11-25T20-13-04.000000-p"));
}

TEST_F(Evidence, SaysWhatCouldNotBeKept) {
  std::ofstream(folder_.path() / "file") << "no folder";
  EvidenceKeeper keeper(folder_.path() / "file", "", 1 << 20);
  keeper.Begin("p: x\n", At(0));
  const auto kept = keeper.KeepIfDue(*log_, "", At(5));
  ASSERT_FALSE(kept);
  EXPECT_EQ(kept.error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace gw::record

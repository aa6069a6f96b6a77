#include "common/process/health_reporter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gw::process {
namespace {

TEST(HealthReporter, ReportsOnceASecond) {
  HealthReporter reporter("gw-test", "1.0", 7);
  EXPECT_TRUE(reporter.ReportIfDue(Utime{0}));
  EXPECT_FALSE(reporter.ReportIfDue(Utime{999'999}));
  const auto report = reporter.ReportIfDue(Utime{1'000'000});
  ASSERT_TRUE(report);
  EXPECT_EQ(report->seq, 2);
  EXPECT_EQ(report->utime.us, 1'000'000);
  EXPECT_EQ(report->process, "gw-test");
  EXPECT_EQ(report->version, "1.0");
  EXPECT_EQ(report->config_hash, 7u);
}

TEST(HealthReporter, PercentilesAreThoseOfTheLastSecond) {
  HealthReporter reporter("gw-test", "1.0", 0);
  for (int i = 1000; i >= 1; --i) reporter.AddLatency(DurationUs{i});
  const auto full = reporter.ReportIfDue(Utime{0});
  EXPECT_EQ(full->latency_p50_us, 500);
  EXPECT_EQ(full->latency_p99_us, 990);
  EXPECT_EQ(full->latency_max_us, 1000);
  reporter.AddLatency(DurationUs{5});
  const auto one = reporter.ReportIfDue(Utime{1'000'000});
  EXPECT_EQ(one->latency_p50_us, 5);
  EXPECT_EQ(one->latency_p99_us, 5);
  EXPECT_EQ(one->latency_max_us, 5);
  const auto none = reporter.ReportIfDue(Utime{2'000'000});
  EXPECT_EQ(none->latency_max_us, 0);
}

TEST(HealthReporter, CountersOnlyGrowAndAreSorted) {
  HealthReporter reporter("gw-test", "1.0", 0);
  reporter.Count("imu.lost", 0);
  reporter.Count("camera.lost", 3);
  reporter.Count("camera.lost");
  using C = std::pair<std::string, int64_t>;
  EXPECT_THAT(reporter.ReportIfDue(Utime{0})->counters,
              ::testing::ElementsAre(C{"camera.lost", 4}, C{"imu.lost", 0}));
  EXPECT_EQ(reporter.counter("camera.lost"), 4);
  EXPECT_EQ(reporter.counter("none"), 0);
  reporter.SetCounter("camera.lost", 9);
  EXPECT_EQ(reporter.counter("camera.lost"), 9);
  EXPECT_EQ(reporter.ReportIfDue(Utime{1'000'000})->counters.size(), 2u);
}

TEST(HealthReporter, QueuePeakIsOfTheLastSecondAndStateStays) {
  HealthReporter reporter("gw-test", "1.0", 0);
  EXPECT_EQ(reporter.ReportIfDue(Utime{0})->state, HealthState::kStarting);
  reporter.NoteQueue(3);
  reporter.NoteQueue(8);
  reporter.NoteQueue(1);
  reporter.SetState(HealthState::kDegraded, "no camera: check the USB cable");
  EXPECT_EQ(reporter.ReportIfDue(Utime{1'000'000})->queue_peak, 8);
  const auto next = reporter.ReportIfDue(Utime{2'000'000});
  EXPECT_EQ(next->queue_peak, 0);
  EXPECT_EQ(next->state, HealthState::kDegraded);
  EXPECT_EQ(next->message, "no camera: check the USB cable");
}

TEST(HealthReporter, AFloodOfStepsTakesBoundedMemory) {
  HealthReporter reporter("gw-test", "1.0", 0);
  for (size_t i = 0; i < 3 * HealthReporter::kMaxLatencies; ++i) reporter.AddLatency(DurationUs{1});
  EXPECT_EQ(reporter.ReportIfDue(Utime{0})->latency_p99_us, 1);
}

TEST(HealthReporter, SaysWhyMessagesAreRefusedWhileTheyAre) {
  HealthReporter reporter("gw-test", "1", 0);
  reporter.SetState(HealthState::kOk);
  reporter.CountUndecodable("WHEEL", "wheel_t: dx_m: not finite");
  auto report = reporter.ReportIfDue(Utime{1'000'000});
  ASSERT_TRUE(report);
  EXPECT_EQ(report->state, HealthState::kDegraded);
  EXPECT_NE(report->message.find("WHEEL are refused: wheel_t: dx_m"), std::string::npos);
  report = reporter.ReportIfDue(Utime{2'100'000});
  ASSERT_TRUE(report);
  EXPECT_EQ(report->state, HealthState::kOk);
  EXPECT_EQ(report->message, "");
  EXPECT_EQ(reporter.counter("WHEEL.undecodable"), 1);
}

}  // namespace
}  // namespace gw::process

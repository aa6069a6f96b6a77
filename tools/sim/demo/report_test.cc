#include "tools/sim/demo/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "common/process/bus.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/data/files/json.h"
#include "tools/sim/demo/base64.h"
#include "tools/sim/demo/charts.h"
#include "tools/sim/demo/run_recorder.h"

namespace gw::demo {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Base64, TheVectorsOfRfc4648) {
  EXPECT_EQ(Base64(std::string("")), "");
  EXPECT_EQ(Base64(std::string("f")), "Zg==");
  EXPECT_EQ(Base64(std::string("fo")), "Zm8=");
  EXPECT_EQ(Base64(std::string("foo")), "Zm9v");
  EXPECT_EQ(Base64(std::string("foobar")), "Zm9vYmFy");
  EXPECT_EQ(Base64(std::vector<uint8_t>{0xff, 0xfe, 0xfd}), "//79");
}

// Ten seconds along x at 0.5 m/s, images at 10 Hz; blind in [4, 6), when the estimate goes 2 % too
// far. The truth is turned and moved against W.
class RunOnABus : public ::testing::Test {
 protected:
  void Play(bool with_truth) {
    ASSERT_TRUE(tools::Monitor::Attach(bus_, monitor_).ok());
    ASSERT_TRUE(ImageSamples::Attach(bus_, images_).ok());
    ASSERT_TRUE(RunRecorder::Attach(bus_, recorder_).ok());
    const SE3 T_GW(ExpSO3({0, 0, 1}), {3, 2, 0});
    for (int i = 0; i < 100; ++i) {
      const Utime utime{1'000'000'000 + i * 100'000};
      const bool blind = i >= 40 && i < 60;
      const double way = 0.05 * i;
      const SE3 T_WB(Eigen::Quaterniond::Identity(), {way + (i < 40 ? 0 : 0.02), 0, 0});
      PublishImage(utime, i + 1);
      if (with_truth) {
        const SE3 T_GB = T_GW * SE3(Eigen::Quaterniond::Identity(), {way, 0, 0});
        Publish(wire::kGroundTruth, wire::Encode(GroundTruth{utime, i + 1, T_GB}));
      }
      FramePose pose;
      pose.utime = utime;
      pose.seq = i + 1;
      pose.T_WB = T_WB;
      pose.status = blind ? TrackingStatus::kDrOnly : TrackingStatus::kTracking;
      pose.q = blind ? 0 : 1;
      pose.alpha = blind ? 1000 : 0.1;
      bus_.set_now(utime + Milliseconds(7));
      Publish(wire::kFramePose, wire::Encode(pose));
    }
    Publish(wire::kNote, wire::Encode(wire::Note{{1'000'000'000}, 1, "navigate.reached", "a < b"}));
  }
  void PublishImage(Utime utime, int64_t seq) {
    const std::vector<uint8_t> pixels(64 * 64, 100);
    CameraFrame camera;
    camera.utime = utime;
    camera.seq = seq;
    camera.left = {pixels.data(), 64, 64, 64, PixelFormat::kGray8};
    camera.right = camera.left;
    bus_.set_now(utime);
    Publish(wire::kCamera, wire::Encode(camera));
  }
  // A thousand images, two a second.
  void PublishLongRun() {
    for (int i = 0; i < 1000; ++i) PublishImage({1'000'000'000 + i * 500'000LL}, i + 1);
  }
  void Publish(const char* channel, const wire::Bytes& message) {
    ASSERT_TRUE(bus_.Publish(channel, message).ok());
    ASSERT_TRUE(bus_.Pump(0).ok());
  }

  process::MemoryBus bus_;
  tools::Monitor monitor_;
  ImageSamples images_;
  RunRecorder recorder_{foxglove::TranslatorOptions()};
};

TEST_F(RunOnABus, IsMeasuredAgainstTheTruth) {
  Play(true);
  const RunAnalysis run = Analyse(monitor_);
  ASSERT_EQ(run.frames.size(), 100u);
  ASSERT_EQ(run.blind.size(), 1u);
  EXPECT_NEAR(run.blind[0].first, 4, 1e-6);
  EXPECT_NEAR(run.blind[0].second, 6, 1e-6);
  EXPECT_NEAR(run.blind_s, 2, 1e-6);
  EXPECT_NEAR(run.way_m, 4.95, 1e-6);
  EXPECT_TRUE(run.has_truth);
  EXPECT_NEAR(run.error_max_m, 0.02, 1e-9);
  EXPECT_NEAR(run.error_end_m, 0.02, 1e-9);
  EXPECT_NEAR(run.error_rmse_m, 0.02 * std::sqrt(0.6), 1e-9);
  EXPECT_NEAR(run.frames[50].latency_ms, 7, 1e-9);
  EXPECT_NEAR(*ErrorNow().Of(monitor_), 0, 1e-9) << "tied at the only image it has looked at";
}

TEST_F(RunOnABus, WithoutTruthItHasAWayButNoError) {
  Play(false);
  const RunAnalysis run = Analyse(monitor_);
  EXPECT_FALSE(run.has_truth);
  EXPECT_NEAR(run.way_m, 4.97, 1e-6);
  EXPECT_FALSE(ErrorNow().Of(monitor_).has_value());
  EXPECT_THAT(TimeChart(run).svg, Not(HasSubstr("truth")));
}

TEST_F(RunOnABus, IsKeptAsTheViewerShowsIt) {
  Play(true);
  std::map<std::string, int> counts;
  for (const tools::Json& message : recorder_.Messages()) ++counts[message[0].get<std::string>()];
  EXPECT_EQ(counts["/weights"], 100);
  EXPECT_NEAR(counts["/camera/image"], 34, 2) << "every 250 ms of 10 s at 10 Hz";
  EXPECT_NEAR(counts["/tf"], 50, 2);
  EXPECT_GE(counts["/trajectory"], 1);
  EXPECT_GE(counts["/log"], 3) << "blind, sees again, and the note";
  EXPECT_GT(counts["/error"], 50);
}

TEST_F(RunOnABus, ThePageHasTheRunInIt) {
  Play(true);
  ReportInput input;
  input.title = "run <1>";
  input.monitor = &monitor_;
  input.images = &images_;
  const auto html = RenderReport(input, "<i>\"the data of the report\"</i>", recorder_.Messages());
  ASSERT_TRUE(html.ok()) << html.error().message;
  const auto data = tools::Json::parse(html->substr(3, html->size() - 7));
  EXPECT_EQ(data["title"], "Run of run <1>");
  EXPECT_EQ(data["facts"][2][1], "2.0 s in 1 spans");
  EXPECT_GT(data["messages"].size(), 200u);
  EXPECT_EQ(data["figures"].size(), 2u);
}

TEST_F(RunOnABus, ALongRunHasNoMoreImages) {
  ASSERT_TRUE(RunRecorder::Attach(bus_, recorder_).ok());
  PublishLongRun();
  const size_t kept = recorder_.Messages().size();
  EXPECT_LE(kept, RunRecorder::kMostImages);
  EXPECT_GE(kept, RunRecorder::kMostImages / 2);
}

TEST_F(RunOnABus, ThePlainFormNeedsNothingElse) {
  Play(true);
  ReportInput input;
  input.title = "run <1>";
  input.monitor = &monitor_;
  input.images = &images_;
  const auto html = RenderPlainReport(input);
  ASSERT_TRUE(html.ok()) << html.error().message;
  EXPECT_THAT(*html, HasSubstr("Run of run &lt;1>"));
  EXPECT_THAT(*html, HasSubstr("a &lt; b"));
  EXPECT_THAT(*html, HasSubstr("2.0 s in 1 spans"));
  EXPECT_THAT(*html, HasSubstr("data:image/jpeg;base64,"));
  EXPECT_THAT(*html, HasSubstr("data:image/svg+xml;base64,"));
  EXPECT_THAT(*html, Not(HasSubstr("http")));
}

TEST_F(RunOnABus, ARunWithoutAPoseIsAnErrorThatSaysWhatToLookAt) {
  ReportInput input;
  input.monitor = &monitor_;
  input.images = &images_;
  const auto html = RenderPlainReport(input);
  ASSERT_FALSE(html.ok());
  EXPECT_THAT(html.error().message, HasSubstr("gw-frontend"));
}

TEST_F(RunOnABus, ImagesAreKeptEvenlyHoweverLongTheRun) {
  ASSERT_TRUE(ImageSamples::Attach(bus_, images_).ok());
  PublishLongRun();
  const auto& samples = images_.samples();
  EXPECT_LE(samples.size(), ImageSamples::kMost);
  EXPECT_GE(samples.size(), ImageSamples::kMost / 2);
  EXPECT_GT((samples.back().utime - samples.front().utime).seconds(), 495);
  for (size_t i = 1; i < samples.size(); ++i) {
    EXPECT_EQ((samples[i].utime - samples[i - 1].utime).us,
              (samples[1].utime - samples[0].utime).us);
  }
}

}  // namespace
}  // namespace gw::demo

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <stdexcept>

#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/data/fault/apply_faults.h"
#include "tools/data/log/inspect.h"

namespace gw::fault {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr int kWidth = 64, kHeight = 48;
constexpr int64_t kBegin = 5'000'000;

// A robot that drives straight at 1 m/s for 4 s and then turns on the spot at 0.5 rad/s for 2 s.
// CAMERA 10 Hz, DR and IMU 100 Hz, WHEEL 50 Hz with ticks and heading, GROUND_TRUTH 10 Hz, and a
// POSE, which is an estimate.
SE3 PoseAt(double t) {
  return SE3(ExpSO3({0, 0, 0.5 * std::max(0.0, t - 4)}), {std::min(t, 4.0), 0, 0});
}

struct Decoded {
  std::vector<wire::DecodedCamera> camera;
  std::vector<Utime> camera_received;
  std::vector<ImuSample> imu;
  std::vector<WheelSample> wheel;
  std::vector<DrState> dr;
  std::vector<GroundTruth> truth;
  std::vector<wire::Note> notes;
  int others = 0;
};

class Fault : public testing::Test {
 protected:
  Fault() {
    std::string name = (fs::temp_directory_path() / "gw_fault_test_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = name;
    WriteInput();
  }
  ~Fault() override { fs::remove_all(folder_); }
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  FaultSummary Apply(const FaultArguments& arguments) {
    const auto plan = ParseFaultPlan(arguments);
    EXPECT_TRUE(plan) << plan.error().message;
    const auto summary =
        ApplyFaults(Path("in.lcm"), *plan, Path("out.lcm"), [](int64_t, int64_t) {});
    EXPECT_TRUE(summary) << summary.error().message;
    return *summary;
  }
  Decoded Read(const std::string& name) const {
    Decoded out;
    auto reader = process::EventLogReader::Open(Path(name));
    EXPECT_TRUE(reader);
    while (const auto event = reader->Next()) {
      if (event->channel == wire::kCamera) {
        out.camera.push_back(*wire::Decode<wire::DecodedCamera>(event->data));
        out.camera_received.push_back(event->received);
      } else if (event->channel == wire::kImu) {
        out.imu.push_back(*wire::Decode<ImuSample>(event->data));
      } else if (event->channel == wire::kWheel) {
        out.wheel.push_back(*wire::Decode<WheelSample>(event->data));
      } else if (event->channel == wire::kDr) {
        out.dr.push_back(*wire::Decode<DrState>(event->data));
      } else if (event->channel == wire::kGroundTruth) {
        out.truth.push_back(*wire::Decode<GroundTruth>(event->data));
      } else if (event->channel == wire::kNote) {
        out.notes.push_back(*wire::Decode<wire::Note>(event->data));
      } else {
        ++out.others;
      }
    }
    return out;
  }
  tools::LogReport Check() const {
    auto report = tools::InspectLog(Path("out.lcm"), tools::InspectDepth::kDecode);
    EXPECT_TRUE(report);
    return *report;
  }

 private:
  void WriteInput() {
    auto writer = process::EventLogWriter::Create(Path("in.lcm"));
    ASSERT_TRUE(writer);
    const auto append = [&](const char* channel, auto message, int64_t seq) {
      message.seq = seq;
      ASSERT_TRUE(writer->Append(message.utime, channel, wire::Encode(message)));
    };
    wire::Note note;
    note.utime = {kBegin};
    note.key = "source";
    append(wire::kNote, note, 1);
    std::vector<uint8_t> grey(kWidth * kHeight);
    std::vector<uint16_t> depth(kWidth * kHeight);
    for (int i = 0; i <= 600; ++i) {
      const double t = 0.01 * i;
      const Utime utime = {kBegin + i * 10000};
      ImuSample imu;
      imu.utime = utime;
      imu.w_I_rad_s.z() = t > 4 ? 0.5 : 0;
      append(wire::kImu, imu, i + 1);
      if (i > 0 && i % 2 == 0) {
        const SE3 T = PoseAt(t - 0.02).inverse() * PoseAt(t);
        WheelSample wheel;
        wheel.utime = utime;
        wheel.utime_begin = utime - DurationUs{20000};
        wheel.dx_m = T.translation().x();
        wheel.dyaw_rad = LogSO3(T.rotation()).z();
        wheel.has_ticks = wheel.has_heading = true;
        wheel.left_ticks = wheel.right_ticks =
            static_cast<uint16_t>(65000 + std::lround(10000 * std::min(t, 4.0)));  // wraps
        wheel.heading_rad = LogSO3(PoseAt(t).rotation()).z();
        append(wire::kWheel, wheel, i / 2);
      }
      DrState dr;
      dr.utime = utime;
      dr.T_OB = PoseAt(t);
      append(wire::kDr, dr, i + 1);
      if (i % 10 != 0) continue;
      std::fill(grey.begin(), grey.end(), static_cast<uint8_t>(i / 10));
      grey[100] = 255;  // something to blur
      std::fill(depth.begin(), depth.end(), static_cast<uint16_t>(1000 + i));
      CameraFrame frame;
      frame.utime = utime;
      frame.left = {grey.data(), kWidth, kHeight, kWidth, PixelFormat::kGray8};
      frame.depth = {reinterpret_cast<const uint8_t*>(depth.data()), kWidth, kHeight, 2 * kWidth,
                     PixelFormat::kDepth16};
      append(wire::kCamera, frame, i / 10 + 1);
      GroundTruth truth;
      truth.utime = utime;
      truth.T_GB = PoseAt(t);
      append(wire::kGroundTruth, truth, i / 10 + 1);
      Pose pose;
      pose.utime = utime;
      append(wire::kPose, pose, i / 10 + 1);
    }
    ASSERT_TRUE(writer->Close());
  }

  fs::path folder_;
};

int Grey(const wire::DecodedCamera& camera) {
  return camera.frame.left.data[0];
}
int Depth(const wire::DecodedCamera& camera) {
  uint16_t value = 0;
  std::memcpy(&value, camera.frame.depth.data, 2);
  return value;
}
SE3 Chain(const std::vector<WheelSample>& wheel) {
  SE3 T;
  for (const WheelSample& w : wheel) {
    T = T * SE3(ExpSO3({0, 0, w.dyaw_rad}), {w.dx_m, w.dy_m, 0});
  }
  return T;
}

TEST_F(Fault, BlackCoversTheLensInTheSpanOnly) {
  FaultArguments a;
  a.black = {"1:2"};
  EXPECT_EQ(Apply(a).black_frames, 10);
  const Decoded out = Read("out.lcm");
  ASSERT_EQ(out.camera.size(), 61u);
  for (int i = 0; i <= 60; ++i) {
    const bool black = i >= 10 && i < 20;
    EXPECT_EQ(Grey(out.camera[i]), black ? 0 : i);
    EXPECT_EQ(Depth(out.camera[i]), black ? 0 : 1000 + 10 * i);
    EXPECT_EQ(out.camera[i].frame.left.data[100], black ? 0 : 255);
  }
  EXPECT_TRUE(Check().ok);
}

TEST_F(Fault, EditsAreNotedBehindTheFirstNotesAndEstimatesLeftOut) {
  FaultArguments a;
  a.black = {"1:2"};
  a.gyro_bias_rad_s = 0.1;
  EXPECT_EQ(Apply(a).left_out, 61);
  const Decoded out = Read("out.lcm");
  ASSERT_EQ(out.notes.size(), 3u);
  EXPECT_EQ(out.notes[0].key, "source");
  EXPECT_EQ(out.notes[1].key, "edit.black");
  EXPECT_EQ(out.notes[1].text, "1.000000 s to 2.000000 s");
  EXPECT_EQ(out.notes[2].key, "edit.gyro_bias");
  EXPECT_EQ(out.others, 0);
}

TEST_F(Fault, MessagesThatNoEditTouchesKeepTheirBytes) {
  FaultArguments a;
  a.freeze = {"1:2"};
  a.gyro_bias_rad_s = 0.1;
  Apply(a);
  const auto all = [&](const char* name) {
    std::multimap<std::pair<int64_t, std::string>, wire::Bytes> events;
    auto reader = process::EventLogReader::Open(Path(name));
    while (const auto event = reader->Next()) {
      const int64_t t = event->received.us - kBegin;
      const std::string channel(event->channel);
      if (channel == "NOTE" || channel == "IMU" || channel == "POSE") continue;
      if (channel == "CAMERA" && t >= 1000000 && t < 2000000) continue;
      events.emplace(std::pair{t, channel}, wire::Bytes(event->data.begin(), event->data.end()));
    }
    return events;
  };
  EXPECT_TRUE(all("in.lcm") == all("out.lcm"));
}

TEST_F(Fault, FreezeRepeatsTheLastImageWithNewTimes) {
  FaultArguments a;
  a.freeze = {"1.05:2.05"};
  EXPECT_EQ(Apply(a).frozen_frames, 10);
  const Decoded out = Read("out.lcm");
  for (int i = 0; i <= 60; ++i) {
    EXPECT_EQ(Grey(out.camera[i]), i > 10 && i <= 20 ? 10 : i);
    EXPECT_EQ(Depth(out.camera[i]), 1000 + 10 * (i > 10 && i <= 20 ? 10 : i));
    EXPECT_EQ(out.camera[i].frame.utime.us, kBegin + i * 100000);
    EXPECT_EQ(out.camera[i].frame.seq, i + 1);
  }
}

TEST_F(Fault, BlurSpreadsGreyAndLeavesDepth) {
  FaultArguments a;
  a.blur = {":0.35:2"};
  EXPECT_EQ(Apply(a).blurred_frames, 4);
  const Decoded out = Read("out.lcm");
  EXPECT_LT(out.camera[3].frame.left.data[100], 100);
  EXPECT_GT(out.camera[3].frame.left.data[101], 3);
  EXPECT_EQ(Depth(out.camera[3]), 1030);
  EXPECT_EQ(out.camera[4].frame.left.data[100], 255);
}

TEST_F(Fault, DropLosesMessagesVisiblyAndIsSeeded) {
  FaultArguments a;
  a.drop = {"1:2"};
  EXPECT_EQ(Apply(a).dropped_frames, 10);
  EXPECT_EQ(Check().channels.at("CAMERA").lost, 10);
  a.drop = {"::0.5"};
  const int64_t dropped = Apply(a).dropped_frames;
  EXPECT_GT(dropped, 15);
  EXPECT_LT(dropped, 46);
  const Decoded first = Read("out.lcm");
  Apply(a);
  const Decoded again = Read("out.lcm");
  a.seed = 2;
  Apply(a);
  const Decoded other = Read("out.lcm");
  const auto seqs = [](const Decoded& d) {
    std::vector<int64_t> out;
    for (const auto& camera : d.camera) out.push_back(camera.frame.seq);
    return out;
  };
  EXPECT_EQ(seqs(first), seqs(again));
  EXPECT_NE(seqs(first), seqs(other));
}

TEST_F(Fault, DelayMovesTheReceiveTimeOnly) {
  FaultArguments a;
  a.delay = {"CAMERA:155"};
  EXPECT_EQ(Apply(a).delayed, 61);
  const Decoded out = Read("out.lcm");
  ASSERT_EQ(out.camera.size(), 61u);
  for (int i = 0; i <= 60; ++i) {
    EXPECT_EQ(out.camera[i].frame.utime.us, kBegin + i * 100000);
    EXPECT_EQ(out.camera_received[i].us, kBegin + i * 100000 + 155000);
  }
  EXPECT_TRUE(Check().ok);  // events still in order of their receive times
}

TEST_F(Fault, SlipScalesWhatWheelsAndDeadReckoningMeasure) {
  FaultArguments a;
  a.slip = {"1:2:1.5"};
  Apply(a);
  const Decoded in = Read("in.lcm");
  const Decoded out = Read("out.lcm");
  // 1 m of the 4 m counts half as much again.
  EXPECT_NEAR(Chain(out.wheel).translation().norm(), 4.5, 0.011);
  EXPECT_NEAR(LogSO3(Chain(out.wheel).rotation()).z(), 1, 1e-9);
  EXPECT_NEAR(out.dr.back().T_OB.translation().x(), 4.5, 0.011);
  EXPECT_NEAR(LogSO3(out.dr.back().T_OB.rotation()).z(), 1, 1e-9);
  EXPECT_EQ(out.dr[50].T_OB.translation(), in.dr[50].T_OB.translation());
  EXPECT_EQ(static_cast<uint16_t>(out.wheel.back().left_ticks - in.wheel.back().left_ticks), 5000);
  EXPECT_EQ(out.wheel.back().heading_rad, in.wheel.back().heading_rad);
  EXPECT_TRUE(Check().ok);
}

TEST_F(Fault, GyroBiasIsAddedOnEachAxis) {
  FaultArguments a;
  a.gyro_bias_rad_s = -0.02;
  EXPECT_EQ(Apply(a).biased, 601);
  const Decoded out = Read("out.lcm");
  EXPECT_EQ(out.imu.front().w_I_rad_s, Eigen::Vector3d(-0.02, -0.02, -0.02));
  EXPECT_NEAR(out.imu.back().w_I_rad_s.z(), 0.48, 1e-12);
}

// Carried from x = 1 to x = 3: no sensor may notice, only the true pose and the images jump.
TEST_F(Fault, TeleportCutsTheSpanWithoutATraceInTheMotionSensors) {
  FaultArguments a;
  a.teleport = {"1:3"};
  const FaultSummary summary = Apply(a);
  EXPECT_EQ(summary.teleported, 200 + 100 + 200 + 20 + 20);
  const Decoded out = Read("out.lcm");
  EXPECT_TRUE(Check().ok) << tools::ReportText(Check());  // no gap in seq, time in order
  EXPECT_EQ(out.camera.size(), 41u);
  EXPECT_EQ(out.camera[10].frame.utime.us, kBegin + 1000000);
  EXPECT_EQ(Grey(out.camera[10]), 30);
  EXPECT_NEAR(out.truth[9].T_GB.translation().x(), 0.9, 1e-9);
  EXPECT_NEAR(out.truth[10].T_GB.translation().x(), 3.0, 1e-9);
  for (size_t i = 1; i < out.dr.size(); ++i) {
    EXPECT_EQ((out.dr[i].utime - out.dr[i - 1].utime).us, 10000);
    EXPECT_LT((out.dr[i].T_OB.translation() - out.dr[i - 1].T_OB.translation()).norm(), 0.011);
  }
  EXPECT_NEAR(out.dr.back().T_OB.translation().x(), 2, 0.011);
  EXPECT_NEAR(Chain(out.wheel).translation().x(), 2, 0.021);
  for (size_t i = 1; i < out.wheel.size(); ++i) {
    EXPECT_EQ(out.wheel[i].utime_begin, out.wheel[i - 1].utime) << i;
    EXPECT_LE(std::abs(static_cast<int16_t>(out.wheel[i].left_ticks - out.wheel[i - 1].left_ticks)),
              201);
  }
}

// The heading of the base is a gyro's: it does not feel the part of the turn that was cut out.
TEST_F(Fault, TeleportDuringATurnLeavesTheHeadingContinuous) {
  FaultArguments a;
  a.teleport = {"4.5:5.5"};
  Apply(a);
  const Decoded out = Read("out.lcm");
  EXPECT_NEAR(out.wheel.back().heading_rad, 0.5, 0.011);
  EXPECT_NEAR(LogSO3(out.dr.back().T_OB.rotation()).z(), 0.5, 0.006);
  EXPECT_NEAR(LogSO3(out.truth.back().T_GB.rotation()).z(), 1.0, 1e-9);
}

TEST_F(Fault, SameInputAndSeedGiveTheSameBytes) {
  FaultArguments a;
  a.drop = {"::0.3"};
  a.blur = {"0:3:1.5"};
  a.teleport = {"2:2.5", "1:1.5"};
  a.delay = {"DR:33", "CAMERA:50"};
  const auto bytes = [&] {
    Apply(a);
    auto reader = process::EventLogReader::Open(Path("out.lcm"));
    wire::Bytes all;
    while (const auto event = reader->Next()) {
      all.insert(all.end(), event->data.begin(), event->data.end());
    }
    return all;
  };
  EXPECT_TRUE(bytes() == bytes());
}

TEST_F(Fault, NamedFaultsAreNotedWithTheirTimes) {
  FaultArguments a;
  a.fault = {"wheels_late_150ms", "wheels_jump:2:", "half_covered:1:2"};
  EXPECT_EQ(Apply(a).named, 300 + 601 + 61);
  const Decoded out = Read("out.lcm");
  ASSERT_EQ(out.notes.size(), 4u);
  EXPECT_EQ(out.notes[1].key, "edit.fault.wheels_late_150ms");
  EXPECT_THAT(out.notes[2].text, HasSubstr("from 2.000000 s: one increment is 5 m too long"));
  EXPECT_NEAR(Chain(out.wheel).translation().x(), 9, 1e-6);
  EXPECT_EQ(out.wheel[0].utime.us, kBegin + 20000 + 150000);
  EXPECT_NEAR(out.dr.back().T_OB.translation().x(), 9, 1e-6);
  EXPECT_EQ(Depth(out.camera[9]), 1090);
  EXPECT_EQ(Depth(out.camera[10]), 0);
  // Received later as well, so that the log stays in order.
  auto report = tools::InspectLog(Path("out.lcm"), tools::InspectDepth::kDecode);
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->ok) << tools::ReportText(*report);
}

TEST_F(Fault, DamagedLogsAreEditedAndBadFilesRefused) {
  fs::resize_file(Path("in.lcm"), fs::file_size(Path("in.lcm")) - 5);
  FaultArguments a;
  a.black = {"1:2"};
  EXPECT_EQ(Apply(a).black_frames, 10);
  const auto plan = ParseFaultPlan(a);
  ASSERT_TRUE(plan);
  const auto nothing = [](int64_t, int64_t) {};
  EXPECT_EQ(ApplyFaults(Path("none"), *plan, Path("x"), nothing).error().code,
            ErrorCode::kNotFound);
  EXPECT_EQ(ApplyFaults(Path("in.lcm"), *plan, Path("in.lcm"), nothing).error().code,
            ErrorCode::kInvalidArgument);
  fs::resize_file(Path("in.lcm"), 10);
  EXPECT_EQ(ApplyFaults(Path("in.lcm"), *plan, Path("x"), nothing).error().code,
            ErrorCode::kBadData);
  EXPECT_FALSE(fs::exists(Path("x")));
  EXPECT_FALSE(fs::exists(Path("x.partial")));
}

TEST(FaultPlan, KindsStandInTheOrderOfTheirIds) {
  for (size_t i = 0; i < FaultKinds().size(); ++i) {
    EXPECT_EQ(static_cast<size_t>(FaultKinds()[i].id), i) << FaultKinds()[i].name;
  }
}

TEST(FaultPlan, RefusesWhatMakesNoSenseAndNamesTheOption) {
  const auto refused = [](const std::function<void(FaultArguments&)>& set, const char* part) {
    FaultArguments a;
    set(a);
    const auto plan = ParseFaultPlan(a);
    ASSERT_FALSE(plan) << part;
    EXPECT_EQ(plan.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(plan.error().message, HasSubstr(part));
  };
  refused([](FaultArguments&) {}, "no edit");
  refused([](FaultArguments& a) { a.black = {"2:1"}; }, "--black 2:1");
  refused([](FaultArguments& a) { a.blur = {"1:2"}; }, "--blur 1:2");
  refused([](FaultArguments& a) { a.blur = {"1:2:0"}; }, "SIGMA");
  refused([](FaultArguments& a) { a.drop = {"1:2:1.5"}; }, "probability");
  refused([](FaultArguments& a) { a.slip = {"1:2"}; }, "--slip");
  refused([](FaultArguments& a) { a.delay = {"CAMERA"}; }, "CHANNEL:MS");
  refused([](FaultArguments& a) { a.delay = {"POSE:10"}; }, "there are CAMERA");
  refused([](FaultArguments& a) { a.delay = {"IMU:-1"}; }, "CHANNEL:MS");
  refused([](FaultArguments& a) { a.teleport = {"1:"}; }, "needs an end");
  refused([](FaultArguments& a) { a.teleport = {"1:3", "2:4"}; }, "overlap");
  refused([](FaultArguments& a) { a.fault = {"none"}; }, "--fault none: there is no fault");
  refused([](FaultArguments& a) { a.fault = {"dots:2:1"}; }, "--fault 2:1");
  refused([](FaultArguments& a) { a.gyro_bias_rad_s = INFINITY; }, "--gyro-bias");
}

}  // namespace
}  // namespace gw::fault

// The whole pipeline from log events to poses, on a synthetic recording: a camera that moves along
// a textured wall, rendered here, with wheels' worth of dead reckoning.
#include "tools/lab/slam/slam_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "common/core/random.h"
#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "tools/lab/slam/run_log.h"
#include "tools/lab/slam/slam_output.h"
#include "tools/lab/slam/variant.h"

namespace gw::tools {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr double kWallDepth = 2.0;  // m
constexpr int64_t kPeriodUs = 33333;

// Blobs on two scales; smooth enough to be sampled, rough enough for corners everywhere.
double WallTexture(double x, double y) {
  const auto lattice = [](double u, double v, uint64_t stream) {
    const int64_t i = std::llround(std::floor(u));
    const int64_t j = std::llround(std::floor(v));
    return CounterRng(3, stream, static_cast<uint64_t>(i * 100003 + j)).Uniform();
  };
  return 40 + 110 * lattice(x * 14, y * 14, 1) + 90 * lattice(x * 37, y * 37, 2);
}

RobotConfig Robot() {
  RobotConfig config;
  config.robot.name = "wall";
  CameraCalibration& c = config.calibration.camera;
  c.kind = CameraKind::kRgbd;
  c.width = kWidth;
  c.height = kHeight;
  c.left = {260, 260, 160, 120, {}};
  Eigen::Matrix3d R_BC;
  R_BC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  c.T_BC = SE3(Eigen::Quaterniond(R_BC), Eigen::Vector3d::Zero());
  config.frontend.orb.num_features = 400;
  config.dr_ekf.source = DrSource::kRecorded;
  config.frontend.variant = Variant::kFull;
  return config;
}

// Sideways with a gentle sway; the wall is always the plane x = kWallDepth of the world.
SE3 TruePose(int i) {
  const double t = i * kPeriodUs * 1e-6;
  return SE3(ExpSO3({0, 0, 0.05 * std::sin(2 * t)}),
             {0.03 * std::sin(3 * t), 0.25 * t, 0.02 * std::sin(t)});
}

struct Rendered {
  std::vector<uint8_t> gray;
  std::vector<uint16_t> depth;
};

Rendered Render(const RobotConfig& config, const SE3& T_WB, bool dark) {
  Rendered out;
  out.gray.resize(kWidth * kHeight);
  out.depth.resize(kWidth * kHeight);
  const SE3 T_WC = T_WB * config.calibration.camera.T_BC;
  const PinholeIntrinsics& k = config.calibration.camera.left;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const Eigen::Vector3d ray_C((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1.0);
      const Eigen::Vector3d ray_W = T_WC.rotation() * ray_C;
      const double scale = (kWallDepth - T_WC.translation().x()) / ray_W.x();
      const Eigen::Vector3d hit = T_WC.translation() + scale * ray_W;
      const size_t at = static_cast<size_t>(v) * kWidth + u;
      out.gray[at] = dark ? 5 : static_cast<uint8_t>(WallTexture(hit.y(), hit.z()));
      out.depth[at] = static_cast<uint16_t>(std::lround(scale * 1000));
    }
  }
  return out;
}

struct Event {
  std::string channel;
  wire::Bytes bytes;
};

std::vector<Event> Recording(int images, int dark_from = 0, int dark_to = 0) {
  const RobotConfig config = Robot();
  std::vector<Event> events;
  for (int i = 0; i < images; ++i) {
    const Utime utime{i * kPeriodUs};
    DrState dr;
    dr.utime = utime;
    dr.seq = i + 1;
    dr.T_OB = SE3(TruePose(i).rotation(), 1.01 * TruePose(i).translation());
    dr.synthetic = true;
    events.push_back({wire::kDr, wire::Encode(dr)});
    const Rendered image = Render(config, TruePose(i), i >= dark_from && i < dark_to);
    CameraFrame frame;
    frame.utime = utime;
    frame.seq = i + 1;
    frame.left = {image.gray.data(), kWidth, kHeight, kWidth, PixelFormat::kGray8};
    frame.depth = {reinterpret_cast<const uint8_t*>(image.depth.data()), kWidth, kHeight,
                   2 * kWidth, PixelFormat::kDepth16};
    events.push_back({wire::kCamera, wire::Encode(frame)});
  }
  return events;
}

SlamSession RunAll(const RobotConfig& config, const std::vector<Event>& events) {
  SlamSession session = *SlamSession::Create(config);
  for (const Event& e : events) session.Process({0, {}, e.channel, e.bytes});
  session.Finish();
  return session;
}

double WorstError(const SlamSession& session) {
  double worst = 0;
  for (size_t i = 0; i < session.frames().size(); ++i) {
    const SE3 error = TruePose(0).inverse() * TruePose(static_cast<int>(i));
    worst = std::max(worst, (session.frames()[i].T_WB.translation() - error.translation()).norm());
  }
  return worst;
}

std::string AllOutputs(const SlamSession& session, const std::string& folder) {
  EXPECT_TRUE(WriteOutputs(folder, Robot(), {"log.lcm", "full"}, session).ok());
  std::ostringstream all;
  for (const char* name : {"trajectory.tum", "trajectory_final.tum", "keyframes.tum", "dr.tum",
                           "frames.csv", "covariance.csv", "dr_prior.csv", "report.json"}) {
    all << std::ifstream(folder + "/" + name).rdbuf();
  }
  return all.str();
}

std::string Scratch(const std::string& name) {
  const auto path = std::filesystem::path(testing::TempDir()) / ("slam_session_test_" + name);
  std::filesystem::remove_all(path);
  return path.string();
}

TEST(SlamSession, FollowsTheWall) {
  const SlamSession session = RunAll(Robot(), Recording(90));
  ASSERT_EQ(session.frames().size(), 90u);
  EXPECT_LT(WorstError(session), 0.02);
  for (const FramePose& f : session.frames()) EXPECT_EQ(f.status, TrackingStatus::kTracking);
  EXPECT_TRUE(session.dr_synthetic());
}

TEST(SlamSession, SameInputGivesTheSameBytes) {
  const auto events = Recording(60, 25, 40);
  const std::string a = AllOutputs(RunAll(Robot(), events), Scratch("a"));
  const std::string b = AllOutputs(RunAll(Robot(), events), Scratch("b"));
  EXPECT_GT(a.size(), 10000u);
  EXPECT_EQ(a, b);
}

TEST(SlamSession, AClockThatMeasuresChangesNothing) {
  const auto events = Recording(20);
  SlamSession session = *SlamSession::Create(Robot());
  int64_t ticks = 0;
  session.MeasureTimes([&ticks] { return ticks += 7; });
  for (const Event& e : events) session.Process({0, {}, e.channel, e.bytes});
  session.Finish();
  EXPECT_EQ(session.tracking_us(), std::vector<int64_t>(20, 7));
  EXPECT_FALSE(session.local_ba_times().empty());
  for (const MeasuredTime& time : session.local_ba_times()) EXPECT_EQ(time.us, 7);
  EXPECT_EQ(AllOutputs(session, Scratch("measured")),
            AllOutputs(RunAll(Robot(), events), Scratch("not_measured")));
}

TEST(SlamSession, KeepsWhatDeadReckoningAloneSays) {
  const SlamSession session = RunAll(Robot(), Recording(20));
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(session.dr_poses()[i]);
    EXPECT_LT((session.dr_poses()[i]->translation() - 1.01 * TruePose(i).translation()).norm(),
              1e-9);
  }
}

SlamSession RunLogged(const std::string& name, const LogRunOptions& options) {
  const std::string path = Scratch(name) + ".lcm";
  auto writer = process::EventLogWriter::Create(path);
  EXPECT_TRUE(writer.ok());
  int i = 0;
  for (const Event& e : Recording(30)) {
    EXPECT_TRUE(writer->Append({kPeriodUs * (i++ / 2)}, e.channel, e.bytes).ok());
  }
  EXPECT_TRUE(writer->Close().ok());
  auto log = process::EventLogReader::Open(path);
  EXPECT_TRUE(log.ok());
  SlamSession session = *SlamSession::Create(Robot());
  EXPECT_TRUE(RunLog(*log, options, &session).ok());
  return session;
}

TEST(SlamSession, KeepsWhatTheFilterFoundWrong) {
  RobotConfig config = Robot();
  config.dr_ekf.source = DrSource::kSensors;
  config.calibration.imu.present = false;
  config.calibration.wheel.present = true;
  SlamSession session = *SlamSession::Create(config);
  for (int i = 0; i < 200; ++i) {
    WheelSample sample;
    sample.utime = {i * 20000};
    sample.seq = i + 1;
    sample.utime_begin = {(i - 1) * 20000};
    sample.dx_m = i == 100 ? 5 : 0.006;
    session.Process({0, {}, wire::kWheel, wire::Encode(sample)});
  }
  session.Finish();
  ASSERT_EQ(session.dr_found().size(), 1u);
  EXPECT_EQ(session.dr_found()[0].diagnosis, dr_ekf::DrDiagnosis::kWheelsJumped);
  EXPECT_THAT(Describe(session.dr_found()[0], session.first_dr()), testing::HasSubstr("after 1."));
  const std::string folder = Scratch("found");
  ASSERT_TRUE(WriteOutputs(folder, config, {"log.lcm", "full"}, session).ok());
  std::ostringstream report;
  report << std::ifstream(folder + "/report.json").rdbuf();
  EXPECT_THAT(report.str(), testing::HasSubstr("wheels_jumped"));
}

TEST(RunLog, ASeedStartsLaterAndKeepsDeadReckoning) {
  const SlamSession session = RunLogged("seed", {.seed = 4, .span = {}});
  ASSERT_EQ(session.frames().size(), 30u - 4 * kImagesPerSeed);
  EXPECT_EQ(session.frames().front().utime.us, 4 * kImagesPerSeed * kPeriodUs);
  EXPECT_TRUE(session.dr_poses().front());
}

TEST(RunLog, ASpanTakesItsImagesOnly) {
  const SlamSession session =
      RunLogged("span", {.seed = 0, .span = {{10 * kPeriodUs}, {20 * kPeriodUs}}});
  ASSERT_EQ(session.frames().size(), 10u);
  EXPECT_EQ(session.frames().front().utime.us, 10 * kPeriodUs);
}

TEST(Variants, AreNamedAsOnTheCommandLine) {
  FrontendConfig config;
  for (const char* name : {"none", "da", "pe", "lba", "full", "switch"}) {
    ASSERT_TRUE(ApplyVariant(name, &config).ok());
    EXPECT_EQ(VariantName(config), name);
  }
  ASSERT_TRUE(ApplyVariant("fixed:2.5e3", &config).ok());
  EXPECT_EQ(config.variant, Variant::kFixed);
  EXPECT_EQ(config.dr_weight.fixed_alpha, 2500);
  for (const char* name : {"", "fixed", "fixed:", "fixed:-1", "fixed:nan", "fixed:1x", "Full"}) {
    EXPECT_FALSE(ApplyVariant(name, &config).ok()) << name;
  }
}

TEST(Variants, NameTheMethodAndItsChanges) {
  FrontendConfig config;
  for (const char* name : {"paper:none", "paper:full", "paper:full+bound+loop_test"}) {
    ASSERT_TRUE(ApplyVariant(name, &config).ok()) << name;
    EXPECT_EQ(VariantName(config), name);
  }
  ASSERT_TRUE(ApplyVariant("paper:pe+drift", &config).ok());
  EXPECT_TRUE(config.dr_weight.Departs(Departure::kDrift));
  EXPECT_FALSE(config.dr_weight.Departs(Departure::kBound));
  ASSERT_TRUE(ApplyVariant("pe", &config).ok());
  EXPECT_EQ(VariantName(config), "paper:pe") << "the method stays that of the configuration";
  ASSERT_TRUE(ApplyVariant("ours:full-two_alphas-bound", &config).ok());
  EXPECT_EQ(VariantName(config), "full-two_alphas-bound");
  ASSERT_TRUE(ApplyVariant("ours:fixed:1e-1-drift", &config).ok());
  EXPECT_EQ(config.dr_weight.fixed_alpha, 0.1);
  EXPECT_TRUE(config.dr_weight.Departs(Departure::kBound));
  EXPECT_FALSE(config.dr_weight.Departs(Departure::kDrift));
  for (const char* name : {"paper:", "paper:full-bound", "ours:full+bound", "ours:full-nothing",
                           "ours:full-drift-drift", "ours:full-", "theirs:full"}) {
    EXPECT_FALSE(ApplyVariant(name, &config).ok()) << name;
  }
}

std::string FileText(const std::string& path) {
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

TEST(Variants, NoneIsBlindToDeadReckoning) {
  const auto with = Recording(90, 40, 50);
  auto without = with;
  std::erase_if(without, [](const Event& e) { return e.channel == wire::kDr; });
  ASSERT_LT(without.size(), with.size());
  for (const char* name : {"ours:none", "paper:none"}) {
    RobotConfig robot = Robot();
    ASSERT_TRUE(ApplyVariant(name, &robot.frontend).ok());
    const auto write = [&](const std::vector<Event>& events, const std::string& folder) {
      const RunDescription run{.log_name = "log", .variant = VariantName(robot.frontend)};
      EXPECT_TRUE(WriteOutputs(folder, robot, run, RunAll(robot, events)).ok());
      return folder;
    };
    const std::string a = write(with, Scratch("with_dr"));
    const std::string b = write(without, Scratch("without_dr"));
    for (const char* file : {"/trajectory.tum", "/trajectory_final.tum", "/keyframes.tum",
                             "/frames.csv", "/covariance.csv"}) {
      EXPECT_FALSE(FileText(a + file).empty());
      EXPECT_EQ(FileText(a + file), FileText(b + file)) << name << file;
    }
    EXPECT_NE(FileText(a + "/dr.tum"), FileText(b + "/dr.tum"));
  }
}

TEST(SlamSession, DarknessIsBridgedIntoTheSameMap) {
  const SlamSession session = RunAll(Robot(), Recording(90, 40, 60));
  EXPECT_EQ(session.frames()[50].status, TrackingStatus::kDrOnly);
  EXPECT_EQ(session.frames().back().status, TrackingStatus::kTracking);
  EXPECT_LT(WorstError(session), 0.03);
}

TEST(SlamSession, DamagedMessagesAreCountedAndTheRunGoesOn) {
  auto events = Recording(40);
  events[11].bytes.resize(events[11].bytes.size() / 2);     // an image cut off
  events[20].bytes.assign(20, 0xFF);                        // a DR state of garbage
  events.insert(events.begin() + 30, {wire::kCamera, {}});  // nothing at all
  const SlamSession session = RunAll(Robot(), events);
  EXPECT_EQ(session.counters().undecodable, 3);
  EXPECT_EQ(session.frames().size(), 39u);
  EXPECT_LT((session.frames().back().T_WB.translation() - TruePose(39).translation()).norm(), 0.03);
}

TEST(SlamSession, ImagesOfAnotherSizeGetAPoseAndAReason) {
  auto events = Recording(10);
  const std::vector<uint8_t> small(64 * 64, 100);
  CameraFrame frame;
  frame.utime = {10 * kPeriodUs};
  frame.seq = 11;
  frame.left = {small.data(), 64, 64, 64, PixelFormat::kGray8};
  events.push_back({wire::kCamera, wire::Encode(frame)});
  const SlamSession session = RunAll(Robot(), events);
  EXPECT_EQ(session.frames().back().reason, TrackingReason::kBadImage);
}

TEST(SlamSession, MissingDepthStartsNoMapButEveryImageHasAPose) {
  auto events = Recording(5);
  for (Event& e : events) {
    if (e.channel != wire::kCamera) continue;
    auto camera = wire::DecodeCamera(e.bytes);
    ASSERT_TRUE(camera.ok());
    camera->frame.depth = {};
    e.bytes = wire::Encode(camera->frame);
  }
  const SlamSession session = RunAll(Robot(), events);
  ASSERT_EQ(session.frames().size(), 5u);
  for (const FramePose& f : session.frames()) {
    EXPECT_EQ(f.status, TrackingStatus::kInitializing);
    EXPECT_EQ(f.reason, TrackingReason::kNoMap);
  }
}

std::string WriteLog(const std::vector<Event>& events, const std::string& name) {
  const std::string path = testing::TempDir() + "slam_session_test_" + name + ".lcm";
  auto log = *process::EventLogWriter::Create(path);
  int64_t received_us = 0;
  for (const Event& e : events) {
    EXPECT_TRUE(log.Append({received_us += 1000}, e.channel, e.bytes).ok());
  }
  EXPECT_TRUE(log.Close().ok());
  return path;
}

// A start in a map that is there: until the place is confirmed the images claim none, then all are
// tracked. Three answers, one every 0.2 s; this wall of noise looks different enough from one image
// to the next that some are not given.
void ExpectFoundSoon(const FramePose* begin, const FramePose* end) {
  const FramePose* found = std::find_if(
      begin, end, [](const FramePose& f) { return f.reason != TrackingReason::kPlaceUnknown; });
  EXPECT_GT(found - begin, 10);
  EXPECT_LT(found - begin, 45);
  for (const FramePose* f = begin; f != found; ++f) {
    EXPECT_EQ(f->status, TrackingStatus::kRecovering);
    EXPECT_GT(f->cov_T_WB(0, 0), 1);
  }
  ASSERT_NE(found, end);
  EXPECT_EQ(found->status, TrackingStatus::kRecovering) << "the place that snaps in is announced";
  for (const FramePose* f = found + 1; f != end; ++f) {
    EXPECT_EQ(f->status, TrackingStatus::kTracking) << f - begin;
  }
}

TEST(SlamSession, LaterLapsAreFoundInTheMapOfTheFirst) {
  constexpr int kImages = 60;
  SlamSession session = *SlamSession::Create(Robot());
  const auto run = RunLaps(WriteLog(Recording(kImages), "laps"), 3, {}, &session);
  ASSERT_TRUE(run.ok());
  ASSERT_EQ(run->laps.size(), 3u);
  ASSERT_EQ(session.frames().size(), 3u * kImages);
  for (size_t n = 0; n < session.frames().size(); ++n) {
    const FramePose& f = session.frames()[n];
    const Lap& lap = run->laps[n / kImages];
    const SE3 truth = TruePose(0).inverse() * TruePose(static_cast<int>(n % kImages));
    EXPECT_EQ((f.utime - lap.shift).us, static_cast<int64_t>(n % kImages) * kPeriodUs);
    EXPECT_LT((f.T_WB.translation() - truth.translation()).norm(), 0.02) << n;
  }
  for (int lap = 1; lap < 3; ++lap) {
    const FramePose* begin = session.frames().data() + kImages * lap;
    ExpectFoundSoon(begin, begin + kImages);
  }
  // The way was known: the map hardly grows.
  EXPECT_GT(run->laps[0].keyframes_inserted, 2);
  EXPECT_LT(run->laps[2].landmarks, 1.2 * static_cast<double>(run->laps[0].landmarks));
  EXPECT_LT(2 * run->laps[2].keyframes_inserted, run->laps[0].keyframes_inserted);
  for (const Lap& lap : run->laps) {
    for (size_t i = 1; i < lap.poses.size(); ++i) {
      EXPECT_GT(lap.poses[i].utime, lap.poses[i - 1].utime);
      EXPECT_LE(lap.poses[i].utime.us, kImages * kPeriodUs);
    }
  }
  // Nobody knows how the robot came from the end of the log to its begin.
  for (const auto& [id, keyframe] : session.mapper().map().keyframes()) {
    const backend::MapKeyframe* before =
        session.mapper().map().FindKeyframe(keyframe.frame.previous);
    if (before == nullptr) continue;
    EXPECT_LT((keyframe.frame.utime - before->frame.utime).us, kImages * kPeriodUs);
    const auto lap_of = [&](Utime utime) { return utime.us / (kImages * kPeriodUs); };
    EXPECT_EQ(lap_of(keyframe.frame.utime), lap_of(before->frame.utime)) << id.value;
  }
  const std::string folder = Scratch("laps");
  ASSERT_TRUE(
      WriteOutputs(folder, Robot(), {.log_name = "l", .variant = "full", .laps = *run}, session)
          .ok());
  std::ifstream second(folder + "/lap2/trajectory.tum");
  double t = -1;
  second >> t;
  EXPECT_EQ(t, 0);
}

TEST(SlamSession, LocalizeOnlyUsesTheMapAndNeverChangesIt) {
  const auto events = Recording(60);
  const SlamSession first = RunAll(Robot(), events);
  const uint64_t before = first.mapper().map().Hash();
  SlamSession second =
      *SlamSession::Create(Robot(), {first.mapper().map(), {}, backend::MapUse::kFrozen});
  for (const Event& e : events) second.Process({0, {}, e.channel, e.bytes});
  second.Finish();
  EXPECT_EQ(second.mapper().map().Hash(), before);
  EXPECT_EQ(second.mapper().counters().keyframes_inserted, 0);
  EXPECT_LT(WorstError(second), 0.02);
  ExpectFoundSoon(second.frames().data(), second.frames().data() + second.frames().size());
}

TEST(SlamSession, OutputThatCannotBeWrittenIsAnErrorThatNamesThePath) {
  const SlamSession session = RunAll(Robot(), Recording(3));
  const auto written = WriteOutputs("/proc/no/such/place", Robot(), {"log.lcm", "full"}, session);
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().code, ErrorCode::kIo);
  EXPECT_THAT(written.error().message, testing::HasSubstr("/proc/no/such/place"));
}

}  // namespace
}  // namespace gw::tools

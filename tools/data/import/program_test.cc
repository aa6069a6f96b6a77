// gw-import as a user runs it: what it writes, what it leaves alone, its exit codes.
#include <gmock/gmock.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include "common/config/loader.h"
#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/data/import/image_file.h"
#include "tools/data/import/test_folder.h"
#include "tools/data/log/inspect.h"

namespace gw::importer {
namespace {

using testing::AllOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

struct RunResult {
  int exit_code;
  std::string out;  // stdout and stderr
};

RunResult RunImport(const std::string& arguments) {
  const std::string command = std::string(GW_BINARY_DIR) + "/gw-import " + arguments + " 2>&1";
  FILE* const pipe = popen(command.c_str(), "r");
  RunResult result{-1, ""};
  char buffer[512];
  while (std::fgets(buffer, sizeof buffer, pipe) != nullptr) result.out += buffer;
  const int status = pclose(pipe);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

std::string FileText(const fs::path& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

// Three frames and ground truth, all channels with something at t = 10.
void WriteSource(const TestFolder& folder) {
  folder.Write("src/rgb.txt", "10.00 rgb/a.png\n10.04 rgb/b.png\n10.08 rgb/c.png\n");
  folder.Write("src/depth.txt", "10.00 depth/a.png\n10.04 depth/b.png\n10.08 depth/c.png\n");
  folder.Write("src/groundtruth.txt",
               "10.0 1 2 3 -0.5 0.5 -0.5 0.5\n10.05 1 2 3 -0.5 0.5 -0.5 0.5\n"
               "10.1 2 2 3 -0.5 0.5 -0.5 0.5\n");
  for (const char* name : {"a", "b", "c"}) {
    folder.WriteGrey(std::string("src/rgb/") + name + ".png", *name);
    folder.WriteDepth(std::string("src/depth/") + name + ".png", *name);
  }
}

std::string Arguments(const TestFolder& folder, const std::string& more = "") {
  const std::string at = folder.path().string();
  return "tum " + at + "/src --out " + at + "/o.lcm --config-out " + at +
         "/o.yaml --intrinsics 60,60,40,32 " + more;
}

struct LoggedMessage {
  int64_t utime_us;
  std::string channel;
  int64_t seq;
  wire::Bytes data;
};

std::vector<LoggedMessage> ReadEvents(const fs::path& file) {
  std::vector<LoggedMessage> events;
  auto reader = process::EventLogReader::Open(file.string());
  EXPECT_TRUE(reader);
  while (const auto event = reader->Next()) {
    const auto header = wire::ReadHeader(event->data);
    EXPECT_TRUE(header);
    EXPECT_EQ(header->utime, event->received);
    events.push_back({event->received.us, std::string(event->channel), header->seq,
                      wire::Bytes(event->data.begin(), event->data.end())});
  }
  return events;
}

TEST(Program, WritesALogInTimeOrderWithAFixedOrderAtEqualTimes) {
  const TestFolder folder;
  WriteSource(folder);
  const RunResult run = RunImport(Arguments(folder, "--dr-from-groundtruth sigma_t=0.004,rate=50"));
  ASSERT_EQ(run.exit_code, 0) << run.out;
  const auto report =
      tools::InspectLog((folder.path() / "o.lcm").string(), tools::InspectDepth::kDecode);
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->ok) << tools::ReportText(*report);
  std::string order;
  int64_t last = 0;
  std::map<std::string, int64_t> seq;
  for (const LoggedMessage& event : ReadEvents(folder.path() / "o.lcm")) {
    EXPECT_GE(event.utime_us, last);
    last = event.utime_us;
    EXPECT_EQ(event.seq, ++seq[event.channel]) << event.channel;
    if (event.channel != wire::kNote) {
      order += event.channel + "@" + std::to_string(event.utime_us / 1000) + " ";
    }
  }
  EXPECT_EQ(order,
            "DR@10000 CAMERA@10000 GROUND_TRUTH@10000 DR@10020 DR@10040 CAMERA@10040 "
            "GROUND_TRUTH@10050 DR@10060 DR@10080 CAMERA@10080 DR@10100 GROUND_TRUTH@10100 ");
}

TEST(Program, PixelsAndNotesComeBackFromTheLog) {
  const TestFolder folder;
  WriteSource(folder);
  ASSERT_EQ(RunImport(Arguments(folder)).exit_code, 0);
  int frames = 0;
  std::string notes;
  for (const LoggedMessage& event : ReadEvents(folder.path() / "o.lcm")) {
    if (event.channel == wire::kNote) {
      const auto note = wire::Decode<wire::Note>(event.data);
      ASSERT_TRUE(note);
      notes += note->key + "=" + note->text + "\n";
    }
    if (event.channel != wire::kCamera) continue;
    const auto camera = wire::Decode<wire::DecodedCamera>(event.data);
    ASSERT_TRUE(camera);
    const char name = static_cast<char>('a' + frames++);
    const auto left = LoadGreyImage(folder.path() / "src/rgb" / (std::string(1, name) + ".png"));
    const auto depth =
        LoadDepthImage(folder.path() / "src/depth" / (std::string(1, name) + ".png"));
    ASSERT_TRUE(left && depth);
    for (int y = 0; y < 64; ++y) {
      const ImageView& l = camera->frame.left;
      const ImageView& d = camera->frame.depth;
      ASSERT_EQ(std::memcmp(l.data + y * l.stride, left->bytes.data() + y * 80, 80), 0);
      ASSERT_EQ(std::memcmp(d.data + y * d.stride, depth->bytes.data() + y * 160, 160), 0);
    }
  }
  EXPECT_EQ(frames, 3);
  EXPECT_THAT(notes, AllOf(HasSubstr("source=tum folder src"), HasSubstr("images=8-bit grey"),
                           HasSubstr("licence="), HasSubstr("warning=neither IMU nor wheels")));
  EXPECT_THAT(notes, testing::Not(HasSubstr(folder.path().string())));
}

TEST(Program, TwiceTheSameInputGivesTheSameBytes) {
  const TestFolder folder;
  WriteSource(folder);
  const std::string dr = "--dr-from-groundtruth sigma_t=0.004,bias_r=1deg,seed=3";
  ASSERT_EQ(RunImport(Arguments(folder, dr)).exit_code, 0);
  const std::string log = FileText(folder.path() / "o.lcm");
  const std::string config = FileText(folder.path() / "o.yaml");
  ASSERT_EQ(RunImport(Arguments(folder, dr)).exit_code, 0);
  EXPECT_TRUE(log == FileText(folder.path() / "o.lcm"));
  EXPECT_EQ(config, FileText(folder.path() / "o.yaml"));
}

TEST(Program, ConfigurationLoadsAndNamesTheSourceOfDeadReckoning) {
  const TestFolder folder;
  WriteSource(folder);
  ASSERT_EQ(RunImport(Arguments(folder)).exit_code, 0);
  auto config = LoadRobotConfig((folder.path() / "o.yaml").string());
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->dr_ekf.source, DrSource::kSensors);
  EXPECT_EQ(config->robot.name, "src");
  EXPECT_EQ(config->calibration.camera.width, 80);
  ASSERT_EQ(RunImport(Arguments(folder, "--dr-from-groundtruth seed=1")).exit_code, 0);
  config = LoadRobotConfig((folder.path() / "o.yaml").string());
  ASSERT_TRUE(config);
  EXPECT_EQ(config->dr_ekf.source, DrSource::kRecorded);
}

TEST(Program, GroundTruthComesAsBodyOrCameraTrajectory) {
  const TestFolder folder;
  WriteSource(folder);
  const std::string out = "--ground-truth-out " + (folder.path() / "gt.tum").string();
  ASSERT_EQ(RunImport(Arguments(folder, out)).exit_code, 0);
  EXPECT_THAT(FileText(folder.path() / "gt.tum"),
              HasSubstr("10.050000 1.000000000 2.000000000 3.000000000 0.000000000 "));
  ASSERT_EQ(RunImport(Arguments(folder, out + " --frame camera")).exit_code, 0);
  EXPECT_THAT(FileText(folder.path() / "gt.tum"),
              HasSubstr("10.050000 1.000000000 2.000000000 3.000000000 -0.500000000 0.500000000 "));
}

TEST(Program, AFailureLeavesAnOlderLogAloneAndNoPartialFile) {
  const TestFolder folder;
  WriteSource(folder);
  folder.Write("o.lcm", "old");
  folder.Write("src/rgb/c.png", "no image");
  const RunResult run = RunImport(Arguments(folder));
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.out, HasSubstr("c.png: cannot be decoded"));
  EXPECT_EQ(FileText(folder.path() / "o.lcm"), "old");
  EXPECT_FALSE(fs::exists(folder.path() / "o.lcm.partial"));
  EXPECT_FALSE(fs::exists(folder.path() / "o.yaml"));
}

TEST(Program, WhatWasImportedIsChecked) {
  const TestFolder folder;
  WriteSource(folder);
  const RunResult checked = RunImport(Arguments(folder));
  ASSERT_EQ(checked.exit_code, 0) << checked.out;
  EXPECT_THAT(checked.out, AllOf(HasSubstr("checked, without following the images"),
                                 HasSubstr("errors"), HasSubstr("[")));
  const RunResult json = RunImport(Arguments(folder, "--json"));
  EXPECT_THAT(json.out, HasSubstr("\"findings\":[{\"severity\":"));
  const RunResult unchecked = RunImport(Arguments(folder, "--no-check"));
  EXPECT_EQ(unchecked.exit_code, 0);
  EXPECT_THAT(unchecked.out, testing::Not(HasSubstr("checked")));
  // A name that a shell would take apart.
  const std::string at = folder.path().string();
  const RunResult named =
      RunImport("tum " + at + "/src --out \"" + at + "/it's a log.lcm\" --config-out " + at +
                "/o.yaml --intrinsics 60,60,40,32");
  ASSERT_EQ(named.exit_code, 0) << named.out;
  EXPECT_THAT(named.out, HasSubstr("checked"));
}

TEST(Program, SkippedFramesAreCountedInSummaryAndLog) {
  const TestFolder folder;
  WriteSource(folder);
  folder.Remove("src/depth/b.png");
  EXPECT_EQ(RunImport(Arguments(folder)).exit_code, 1);
  const RunResult run = RunImport(Arguments(folder, "--skip-missing --json"));
  ASSERT_EQ(run.exit_code, 0) << run.out;
  EXPECT_THAT(run.out, AllOf(HasSubstr("\"skipped_frames\":1"), HasSubstr("\"CAMERA\":2")));
  const auto report =
      tools::InspectLog((folder.path() / "o.lcm").string(), tools::InspectDepth::kDecode);
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->ok);  // seq stays contiguous: nothing was lost on the way
  EXPECT_THAT(tools::ReportText(*report), HasSubstr("skipped: 1 frames"));
}

TEST(Program, BrokenImagesAreNamedTogetherOrSkipped) {
  const TestFolder folder;
  WriteSource(folder);
  folder.WriteGrey("src/rgb/b.png", 0, 64, 64);
  folder.Write("src/depth/c.png", "no image");
  const RunResult refused = RunImport(Arguments(folder));
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.out,
              AllOf(HasSubstr("rgb/b.png: is 64 x 64"), HasSubstr("depth/c.png: cannot be decoded"),
                    HasSubstr("2 of 3 frames"), HasSubstr("--skip-missing")));
  EXPECT_FALSE(fs::exists(folder.path() / "o.lcm"));
  const RunResult run = RunImport(Arguments(folder, "--skip-missing --json"));
  ASSERT_EQ(run.exit_code, 0) << run.out;
  EXPECT_THAT(run.out, AllOf(HasSubstr("\"skipped_frames\":2"), HasSubstr("\"CAMERA\":1")));
  const auto report =
      tools::InspectLog((folder.path() / "o.lcm").string(), tools::InspectDepth::kDecode);
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->ok) << tools::ReportText(*report);
  EXPECT_THAT(tools::ReportText(*report), HasSubstr("skipped: 2 frames whose images cannot"));
  folder.Write("src/rgb/a.png", "no image");
  const RunResult none = RunImport(Arguments(folder, "--skip-missing"));
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.out, HasSubstr("cannot be decoded"));
}

// A robot that stands, turns left and right and stands; wheels at 20 Hz, IMU at 100 Hz: its gyro in
// deg/s, its accelerometer in g, one row nan.
void WriteOdometry(const TestFolder& folder) {
  std::string odometry, imu;
  char line[200];
  double yaw = 0;
  const auto rate = [](double t) { return t < 2 || t > 14 ? 0 : std::sin(0.9 * (t - 2)); };
  for (int i = 0; i <= 1600; ++i) {
    const double t = 0.01 * i;
    yaw += 0.01 * rate(t);
    std::snprintf(line, sizeof line, "%.6f 0 0 0 0 0 %.9f %.9f\n", 500 + t, std::sin(yaw / 2),
                  std::cos(yaw / 2));
    if (i % 5 == 0) odometry += line;
    std::snprintf(line, sizeof line, "%.6f 0.1 0.1 %.9f 0.01 0.01 1.0\n", 500 + t,
                  rate(t) * 180 / M_PI);
    imu += i == 700 ? "507.000000 nan nan nan nan nan nan\n" : line;
  }
  folder.Write("robot/odom.txt", odometry);
  folder.Write("robot/imu.txt", imu);
}

TEST(Program, UnitsOfAnImuAreSaidAndConverted) {
  const TestFolder folder;
  WriteOdometry(folder);
  const std::string at = folder.path().string();
  const std::string command = "odometry " + at + "/robot/odom.txt --imu " + at +
                              "/robot/imu.txt --out " + at + "/o.lcm --config-out " + at +
                              "/o.yaml";
  const RunResult run = RunImport(command);
  ASSERT_EQ(run.exit_code, 0) << run.out;
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("the gyro is in deg/s"), HasSubstr("the accelerometer is in g"),
                    HasSubstr("imu.txt:701: holds nan, null or an empty field; 1 of 1601 rows")));
  double largest_rate = 0, accel = 0;
  for (const LoggedMessage& event : ReadEvents(folder.path() / "o.lcm")) {
    if (event.channel != wire::kImu) continue;
    const auto sample = wire::Decode<ImuSample>(event.data);
    ASSERT_TRUE(sample);
    largest_rate = std::max(largest_rate, sample->w_I_rad_s.z());
    accel = sample->a_I_m_s2.z();
  }
  EXPECT_NEAR(largest_rate, 1, 1e-3);
  EXPECT_NEAR(accel, 9.80665, 1e-6);
  // The clock an hour off: nothing of the IMU is used, and what would help is named.
  std::string late = FileText(folder.path() / "robot/imu.txt");
  for (size_t i = 0; i < late.size(); i = late.find('\n', i) + 1) late.replace(i, 1, "41");
  folder.Write("robot/imu.txt", late);
  const RunResult other_clock = RunImport(command);
  ASSERT_EQ(other_clock.exit_code, 0) << other_clock.out;
  EXPECT_THAT(other_clock.out,
              AllOf(HasSubstr("nothing in common"), HasSubstr("--imu-time-offset 3600.0"),
                    HasSubstr("IMU is left out")));
  const RunResult mended = RunImport(command + " --imu-time-offset 3600");
  EXPECT_THAT(mended.out, testing::Not(HasSubstr("left out: the IMU")));
  EXPECT_THAT(mended.out, HasSubstr("  IMU            1600"));
  EXPECT_EQ(RunImport(command + " --gyro-unit furlongs").exit_code, 2);
}

TEST(Program, ExitCodesFollowTheDocumentedTable) {
  const TestFolder folder;
  WriteSource(folder);
  const std::string at = folder.path().string();
  EXPECT_EQ(RunImport("").exit_code, 2);
  EXPECT_EQ(RunImport("nonsense").exit_code, 2);
  EXPECT_EQ(RunImport("tum " + at + "/src").exit_code, 2);
  EXPECT_EQ(RunImport(Arguments(folder, "--frame sideways")).exit_code, 2);
  EXPECT_EQ(RunImport(Arguments(folder, "--dr-from-groundtruth sigma_r=1")).exit_code, 2);
  EXPECT_EQ(RunImport("tum " + at + "/none --out " + at + "/o.lcm --config-out " + at + "/o.yaml")
                .exit_code,
            1);
  // The principal point lies outside an 80 x 64 image.
  const RunResult bad_calibration =
      RunImport("tum " + at + "/src --intrinsics 60,60,240,32 --out " + at +
                "/o.lcm --config-out " + at + "/o.yaml");
  EXPECT_EQ(bad_calibration.exit_code, 78);
  EXPECT_THAT(bad_calibration.out, HasSubstr("principal point"));
  EXPECT_FALSE(fs::exists(folder.path() / "o.lcm"));
  EXPECT_EQ(RunImport("tum " + at + "/src --intrinsics 60,60,40,32 --out " + at +
                      "/no/o.lcm --config-out " + at + "/o.yaml")
                .exit_code,
            1);
  EXPECT_EQ(RunImport("--help").exit_code, 0);
  EXPECT_EQ(RunImport("tum --help").exit_code, 0);
}

}  // namespace
}  // namespace gw::importer

// gw-slam as a user runs it, on logs without an image: --dr-only, its files, its exit codes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include "common/config/writer.h"
#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"

namespace gw::tools {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

struct RunResult {
  int exit_code;
  std::string out;  // stdout and stderr
};

class Program : public testing::Test {
 protected:
  Program() {
    std::string name = (fs::temp_directory_path() / "gw_slam_test_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = name;
  }
  ~Program() override { fs::remove_all(folder_); }
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  std::string Text(const std::string& name) const {
    std::stringstream text;
    text << std::ifstream(folder_ / name).rdbuf();
    return text.str();
  }

  // A robot that stands for 2 s, then drives 0.4 m/s straight ahead; wheels at 50 Hz, IMU at 100
  // Hz. Times begin at begin_s.
  void WriteLog(const std::string& name, bool with_imu, double begin_s = 100) const {
    auto writer = process::EventLogWriter::Create(Path(name));
    ASSERT_TRUE(writer);
    int64_t wheel_seq = 0, imu_seq = 0;
    for (int i = 0; i <= 600; ++i) {
      const Utime now = UtimeFromSeconds(begin_s) + Milliseconds(10 * i);
      if (with_imu) {
        ImuSample sample;
        sample.utime = now;
        sample.seq = ++imu_seq;
        sample.a_I_m_s2 = {0, 0, 9.81};
        sample.has_accel = true;
        ASSERT_TRUE(writer->Append(now, wire::kImu, wire::Encode(sample)));
      }
      if (i == 0 || i % 2 != 0) continue;
      WheelSample sample;
      sample.utime = now;
      sample.utime_begin = now - Milliseconds(20);
      sample.seq = ++wheel_seq;
      sample.dx_m = i > 200 ? 0.4 * 0.02 : 0;
      ASSERT_TRUE(writer->Append(now, wire::kWheel, wire::Encode(sample)));
    }
    ASSERT_TRUE(writer->Close());
  }
  void WriteConfig(bool with_imu) const {
    RobotConfig config;
    config.robot.name = "blind";
    CameraCalibration& camera = config.calibration.camera;
    camera.width = 640;
    camera.height = 480;
    camera.left = {500, 500, 320, 240, {}};
    config.calibration.imu.present = with_imu;
    config.calibration.imu.rate_hz = 100;
    config.calibration.wheel.present = true;
    std::ofstream(Path("robot.yaml")) << WriteRobotConfig(config, ConfigText::kShort);
  }
  RunResult Run(const std::string& log, const std::string& out, const std::string& more) const {
    const std::string command = std::string(GW_BINARY_DIR) + "/gw-slam " + Path(log) +
                                " --config " + Path("robot.yaml") + " --out " + Path(out) + " " +
                                more + " 2>&1";
    FILE* const pipe = popen(command.c_str(), "r");
    RunResult result{-1, ""};
    char buffer[512];
    while (std::fgets(buffer, sizeof buffer, pipe) != nullptr) result.out += buffer;
    const int status = pclose(pipe);
    result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return result;
  }

 private:
  fs::path folder_;
};

// x of the last line of a TUM file.
double LastX(const std::string& text) {
  std::istringstream lines(text);
  std::string line;
  double t = 0, x = NAN;
  while (std::getline(lines, line)) std::istringstream(line) >> t >> x;
  return x;
}

TEST_F(Program, DrOnlyNeedsNoImage) {
  for (const bool with_imu : {true, false}) {
    SCOPED_TRACE(with_imu);
    WriteLog("a.lcm", with_imu);
    WriteConfig(with_imu);
    const RunResult run = Run("a.lcm", "out", "--dr-only");
    ASSERT_EQ(run.exit_code, 0) << run.out;
    EXPECT_THAT(run.out, HasSubstr("way: "));
    EXPECT_THAT(run.out, HasSubstr("verdict: "));
    EXPECT_NEAR(LastX(Text("out/raw_wheels.tum")), 1.6, 1e-6);
    EXPECT_NEAR(LastX(Text("out/dr.tum")), 1.6, 0.05);
    const std::string report = Text("out/report.json");
    EXPECT_THAT(report, HasSubstr("\"mode\": \"dr-only\""));
    EXPECT_THAT(report, HasSubstr("\"WHEEL\": 300"));
    const std::string covariance = Text("out/dr_covariance.csv");
    EXPECT_GE(std::count(covariance.begin(), covariance.end(), '\n'), 4);
    EXPECT_FALSE(fs::exists(Path("out/trajectory.tum")));
  }
}

TEST_F(Program, DrOnlyGivesTheSameBytesTwice) {
  WriteLog("a.lcm", true);
  WriteConfig(true);
  const RunResult one = Run("a.lcm", "one", "--dr-only");
  const RunResult two = Run("a.lcm", "two", "--dr-only");
  ASSERT_EQ(one.exit_code, 0) << one.out;
  EXPECT_EQ(one.out, two.out);
  for (const char* file : {"dr.tum", "raw_wheels.tum", "dr_covariance.csv", "report.json"}) {
    EXPECT_FALSE(Text(std::string("one/") + file).empty()) << file;
    EXPECT_EQ(Text(std::string("one/") + file), Text(std::string("two/") + file)) << file;
  }
}

// cat late.lcm early.lcm: the second half is an hour earlier.
TEST_F(Program, AJoinedLogIsReadToItsEndAndNamed) {
  WriteLog("late.lcm", true, 5000);
  WriteLog("early.lcm", true, 1400);
  WriteConfig(true);
  std::ofstream(Path("joined.lcm"), std::ios::binary) << Text("late.lcm") << Text("early.lcm");
  const RunResult run = Run("joined.lcm", "out", "--dr-only");
  ASSERT_EQ(run.exit_code, 0) << run.out;
  EXPECT_THAT(run.out, HasSubstr("time goes back by 3606.000 s at event 901"));
  EXPECT_THAT(Text("out/report.json"), HasSubstr("\"WHEEL\": 600"));
  EXPECT_NEAR(LastX(Text("out/raw_wheels.tum")), 3.2, 1e-6);
}

TEST_F(Program, ExitCodesOfDrOnly) {
  WriteLog("a.lcm", true);
  WriteConfig(true);
  EXPECT_EQ(Run("a.lcm", "out", "--dr-only --laps 2").exit_code, 2);
  const RunResult images_wanted = Run("a.lcm", "out", "");
  EXPECT_EQ(images_wanted.exit_code, 1);
  EXPECT_THAT(images_wanted.out, HasSubstr("--dr-only"));
  EXPECT_EQ(Run("none.lcm", "out", "--dr-only").exit_code, 1);
  std::ofstream(Path("empty.lcm")).flush();
  const RunResult empty = Run("empty.lcm", "out", "--dr-only");
  EXPECT_EQ(empty.exit_code, 1);
  EXPECT_THAT(empty.out, HasSubstr("gave no pose"));
  std::ofstream(Path("robot.yaml")) << "nonsense: 1\n";
  EXPECT_EQ(Run("a.lcm", "out", "--dr-only").exit_code, 78);
}

}  // namespace
}  // namespace gw::tools

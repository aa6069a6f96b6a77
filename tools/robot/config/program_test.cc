// gw-config as scripts see it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "common/core/exit_code.h"

namespace gw {
namespace {

using testing::HasSubstr;

constexpr char kRobot[] = GW_SOURCE_DIR "/config/robots/turtlebot2_d435i.yaml";

std::string TempFile(const std::string& name) {
  return testing::TempDir() + "gw_config_program_" + name;
}

std::string Read(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

int RunProgram(const std::string& arguments, const std::string& output = TempFile("output")) {
  const std::string command =
      std::string(GW_BINARY_DIR "/gw-config ") + arguments + " > " + output + " 2>&1";
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(GwConfig, ExitCodesTellUsageFromFileFromContent) {
  EXPECT_EQ(RunProgram(""), kExitUsage);
  EXPECT_EQ(RunProgram("--check no_such.yaml"), kExitFailed);
  std::ofstream(TempFile("bad.yaml")) << "robot: {name: x}\n";
  EXPECT_EQ(RunProgram("--check " + TempFile("bad.yaml")), kExitBadConfig);
  EXPECT_THAT(Read(TempFile("output")), HasSubstr("bad.yaml:1: calibration: missing"));
}

TEST(GwConfig, EffectiveAndShortTextMeanTheSame) {
  ASSERT_EQ(RunProgram("--check " + std::string(kRobot)), kExitOk);
  const std::string said = Read(TempFile("output"));
  const std::string hash = said.substr(said.find("config hash"));
  for (const std::string style : {"--effective ", "--short "}) {
    ASSERT_EQ(RunProgram(style + kRobot, TempFile("written.yaml")), kExitOk);
    ASSERT_EQ(RunProgram("--check " + TempFile("written.yaml")), kExitOk);
    EXPECT_THAT(Read(TempFile("output")), HasSubstr(hash)) << style;
  }
}

}  // namespace
}  // namespace gw

// gw-eval as scripts see it: exit codes and files.
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
using testing::Not;

std::string TempFile(const std::string& name) {
  return testing::TempDir() + "gw_eval_program_" + name;
}

std::string Write(const std::string& name, const std::string& text) {
  std::ofstream(TempFile(name)) << text;
  return TempFile(name);
}

std::string Read(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// Runs gw-eval; what it says goes to the file "output".
int RunProgram(const std::string& arguments) {
  const std::string command =
      std::string(GW_BINARY_DIR "/gw-eval ") + arguments + " > " + TempFile("output") + " 2>&1";
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

constexpr char kTriangle[] =
    "1 0 0 0 0 0 0 1\n1.5 1 0 0 0 0 0 1\n2 1 1 0 0 0 0 1\n2.5 0 0 0 0 0 0 1\n";

TEST(GwEval, WritesTableJsonAndPlot) {
  const std::string ref = Write("ref.tum", kTriangle);
  const std::string json = TempFile("out.json");
  const std::string svg = TempFile("out.svg");
  ASSERT_EQ(RunProgram("--ref " + ref + " --est " + ref + " --keyframes " + ref +
                       " --align yaw --images 8 --json " + json + " --plot " + svg),
            kExitOk)
      << Read(TempFile("output"));
  EXPECT_THAT(Read(TempFile("output")), HasSubstr("50.0 % of 8 images"));
  EXPECT_THAT(Read(json), HasSubstr("\"alignment\": \"yaw\""));
  EXPECT_THAT(Read(json), HasSubstr("\"coverage\": 0.5"));
  EXPECT_THAT(Read(svg), HasSubstr("</svg>"));
}

// The estimate is a second triangle moved by 5 m: each on its own fits, both in one frame cannot.
TEST(GwEval, SpanIsAlignedOnItsOwn) {
  const std::string ref = Write("ref.tum", std::string(kTriangle) +
                                               "11 0 0 0 0 0 0 1\n11.5 1 0 0 0 0 0 1\n"
                                               "12 1 1 0 0 0 0 1\n");
  const std::string est = Write("est.tum", std::string(kTriangle) +
                                               "11 5 0 0 0 0 0 1\n11.5 6 0 0 0 0 0 1\n"
                                               "12 6 1 0 0 0 0 1\n");
  const std::string files = "--ref " + ref + " --est " + est;
  for (const char* span : {":5", "5:", "10:11.1"}) {
    ASSERT_EQ(RunProgram(files + " --span " + span), kExitOk) << Read(TempFile("output"));
    EXPECT_THAT(Read(TempFile("output")), HasSubstr("APE translation (m)            0.0000"));
  }
  ASSERT_EQ(RunProgram(files), kExitOk);
  EXPECT_THAT(Read(TempFile("output")), Not(HasSubstr("APE translation (m)            0.0000")));
  EXPECT_EQ(RunProgram(files + " --span 20:30"), kExitFailed);
  EXPECT_EQ(RunProgram(files + " --span 30:20"), kExitUsage);
}

TEST(GwEval, SmoothsAndSaysHowWellSamplesAreForetold) {
  std::string line;
  for (int i = 0; i < 20; ++i) {
    line += std::to_string(0.1 * i) + " " + std::to_string(0.05 * i) + " 0 0 0 0 0 1\n";
  }
  const std::string in = Write("line.tum", line);
  const std::string out = TempFile("smooth.tum");
  ASSERT_EQ(RunProgram("smooth " + in + " --out " + out + " --rate 30"), kExitOk)
      << Read(TempFile("output"));
  EXPECT_THAT(Read(TempFile("output")), HasSubstr("<- used"));
  EXPECT_THAT(Read(out), HasSubstr("\n1.000000 0.500000000 "));
  ASSERT_EQ(RunProgram("--align none --ref " + in + " --est " + out), kExitOk);
  EXPECT_THAT(Read(TempFile("output")), HasSubstr("APE translation (m)            0.0000"));
  EXPECT_EQ(RunProgram("smooth " + in), kExitUsage);
  EXPECT_EQ(RunProgram("smooth " + in + " --out " + out + " --gyro log.lcm"), kExitUsage);
  EXPECT_EQ(RunProgram("smooth " + Write("ref.tum", kTriangle) + " --out " + out), kExitFailed);
  EXPECT_THAT(Read(TempFile("output")), HasSubstr("too few"));
}

TEST(GwEval, ExitCodesTellUsageFromData) {
  const std::string ref = Write("ref.tum", kTriangle);
  const std::string bad = Write("bad.tum", "1 0 0 0 0 0 0 1\n1.5 1 0 zero 0 0 0 1\n");
  EXPECT_EQ(RunProgram(""), kExitUsage);
  EXPECT_EQ(RunProgram("--ref " + ref + " --est " + ref + " --align sim3"), kExitUsage);
  EXPECT_EQ(RunProgram("--ref " + ref + " --est " + ref + " --images 5 --frames x.csv"),
            kExitUsage);
  EXPECT_EQ(RunProgram("--ref " + ref + " --est " + ref + " --images 3"), kExitFailed);
  EXPECT_EQ(RunProgram("--ref " + ref + " --est " + ref + " --json /no/such/folder/out.json"),
            kExitFailed);
  EXPECT_THAT(Read(TempFile("output")), HasSubstr("/no/such/folder/out.json: cannot be written"));
  EXPECT_EQ(RunProgram("--ref " + ref + " --est " + bad), kExitFailed);
  EXPECT_THAT(Read(TempFile("output")), HasSubstr("bad.tum:2: 'zero' is not a finite number"));
}

}  // namespace
}  // namespace gw

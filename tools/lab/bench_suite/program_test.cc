// gw-bench as scripts see it, on a few rendered seconds: exit codes, files, and that finished cells
// are not run again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>

#include "common/core/exit_code.h"
#include "tools/data/files/text_file.h"

namespace gw {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string Folder() {
  return testing::TempDir() + "gw_bench_program";
}

std::string Read(const std::string& name) {
  const auto text = tools::ReadTextFile(Folder() + "/" + name);
  return text.ok() ? *text : "";
}

// Runs gw-bench; what it says goes to the file "said".
int RunProgram(const std::string& arguments) {
  const std::string command =
      GW_BINARY_DIR "/gw-bench " + arguments + " > " + Folder() + "/said 2>&1";
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(GwBench, RunsASuiteAndDoesNotRepeatWhatIsFinished) {
  std::filesystem::remove_all(Folder());
  std::filesystem::create_directories(Folder());
  const std::string smoke = GW_SOURCE_DIR "/config/suites/smoke.yaml --out " + Folder() + "/out";
  ASSERT_EQ(RunProgram(smoke), kExitOk) << Read("said");
  const std::string table = Read("out/table.md");
  EXPECT_THAT(table, HasSubstr("| full | 1 / 1 | 0."));
  EXPECT_THAT(table, HasSubstr("| none | 1 / 1 | 0."));
  EXPECT_THAT(Read("out/table.csv"), HasSubstr("office,full,1,"));
  EXPECT_THAT(Read("out/ranking.svg"), HasSubstr("</svg>"));
  EXPECT_THAT(Read("out/inputs.svg"), HasSubstr("</svg>"));
  // The perturbed start: three images fewer.
  const std::string first = Read("out/cells/office/full/seed-0/frames.csv");
  const std::string second = Read("out/cells/office/full/seed-1/frames.csv");
  EXPECT_EQ(std::count(first.begin(), first.end(), '\n'),
            std::count(second.begin(), second.end(), '\n') + 3);

  ASSERT_EQ(RunProgram(smoke), kExitOk) << Read("said");
  EXPECT_THAT(Read("said"), HasSubstr("office full seed 1 (was there)"));
  EXPECT_EQ(Read("out/table.md"), table);

  std::filesystem::remove(Folder() + "/out/cells/office/full/seed-0/key");
  ASSERT_EQ(RunProgram(smoke + " --filter full"), kExitOk) << Read("said");
  EXPECT_THAT(Read("said"), HasSubstr("office full seed 0\n"));
  EXPECT_THAT(Read("said"), Not(HasSubstr("none")));

  // A table of what is there so far says what is missing.
  std::filesystem::remove(Folder() + "/out/cells/office/full/seed-1/key");
  EXPECT_EQ(RunProgram("collect " + smoke), kExitFailed);
  EXPECT_THAT(Read("out/table.md"), HasSubstr("office, full, seed 1: not finished"));
}

// Sequences of the kind of CID-SIMS, with the literature beside them.
TEST(GwBench, RunsThePapersProtocol) {
  std::filesystem::create_directories(Folder());
  const std::string suite =
      GW_SOURCE_DIR "/config/suites/cid_like_short.yaml --out " + Folder() + "/cid";
  ASSERT_EQ(RunProgram(suite), kExitOk) << Read("said");
  const std::string table = Read("cid/table.md");
  EXPECT_THAT(table, HasSubstr("| full | 3 / 3 | 0.0"));
  EXPECT_THAT(table, HasSubstr("| paper:full | 3 / 3 | 0.0"));
  EXPECT_THAT(table, HasSubstr("| GFGG* | 80 % | - |"));
  EXPECT_THAT(Read("cid/ranking.svg"), HasSubstr("GFGG*"));
}

TEST(GwBench, ExitCodesTellUsageFromBadSuites) {
  std::filesystem::create_directories(Folder());
  const std::string out = " --out " + Folder() + "/bad";
  EXPECT_EQ(RunProgram(""), kExitUsage);
  EXPECT_EQ(RunProgram("/no/suite.yaml" + out), kExitFailed);
  EXPECT_THAT(Read("said"), HasSubstr("/no/suite.yaml"));
  ASSERT_TRUE(tools::WriteTextFile(Folder() + "/bad.yaml", "name: x\n").ok());
  EXPECT_EQ(RunProgram(Folder() + "/bad.yaml" + out), kExitBadConfig);
  EXPECT_THAT(Read("said"), HasSubstr("bad.yaml:1: inputs: missing"));
  const std::string smoke = GW_SOURCE_DIR "/config/suites/smoke.yaml" + out;
  EXPECT_EQ(RunProgram(smoke + " --filter nothing"), kExitUsage);
  EXPECT_EQ(RunProgram(smoke + " --filter '('"), kExitUsage);
  EXPECT_EQ(RunProgram("run-job " + smoke + " --input office --variant best --seed 0"), kExitUsage);
  EXPECT_EQ(RunProgram("run-job " + smoke + " --input office --variant full --seed 0"),
            kExitFailed);
  EXPECT_THAT(Read("said"), HasSubstr("office is not prepared"));
  EXPECT_EQ(RunProgram("prepare " + smoke + " --input nowhere"), kExitUsage);
}

}  // namespace
}  // namespace gw

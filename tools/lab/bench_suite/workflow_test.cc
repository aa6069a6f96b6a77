#include "tools/lab/bench_suite/workflow.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

namespace gw::bench {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

Workflow TwoCells() {
  Workflow workflow;
  workflow.program = "/opt/my bin/gw-bench";
  workflow.suite_file = "/s/it's.yaml";
  workflow.out = "/out";
  workflow.arguments = {"--runs", "1"};
  SuiteInput used, unused;
  used.name = "used";
  used.path = "/l/used.lcm";
  used.config = "/l/used.yaml";
  unused.name = "unused";
  workflow.inputs = {used, unused};
  workflow.cells = {{"used", "paper:full+corners", 0}, {"used", "full", 3}};
  return workflow;
}

TEST(Workflow, OneCommandALineForEveryJob) {
  auto files = RenderWorkflow(TwoCells());
  std::map<std::string, std::string> text(files.begin(), files.end());
  const std::string common = R"( '/s/it'\''s.yaml' --out /out --runs 1)";
  EXPECT_EQ(text["inputs.jobs"], "'/opt/my bin/gw-bench' prepare" + common + " --input used\n");
  EXPECT_EQ(text["cells.jobs"], "'/opt/my bin/gw-bench' run-job" + common +
                                    " --input used --variant paper:full+corners --seed 0\n" +
                                    "'/opt/my bin/gw-bench' run-job" + common +
                                    " --input used --variant full --seed 3\n");
  EXPECT_EQ(text["table.jobs"], "'/opt/my bin/gw-bench' collect" + common + "\n");
}

TEST(Workflow, TheSnakefileNamesWhatRunsDependOn) {
  auto files = RenderWorkflow(TwoCells());
  std::map<std::string, std::string> text(files.begin(), files.end());
  EXPECT_THAT(text["Snakefile"],
              AllOf(HasSubstr(R"("used": ["/l/used.lcm", "/l/used.yaml", ])"),
                    HasSubstr(R"("paper-full+corners": "paper:full+corners")"),
                    HasSubstr(R"("cells/used/full/seed-3/done")"), Not(HasSubstr("unused"))));
  EXPECT_THAT(text["slurm/config.yaml"], HasSubstr("cluster-sync: \"srun "));
}

}  // namespace
}  // namespace gw::bench

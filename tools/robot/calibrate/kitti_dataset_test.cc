// A real recording whose right image does not fit its calibration: as a user would use the
// programs.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include "tools/data/files/json.h"
#include "tools/data/import/test_folder.h"

namespace gw::tools {
namespace {

int RunProgram(const std::string& command) {
  const int status = std::system((std::string(GW_BINARY_DIR "/") + command + " 2>&1").c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

tools::Json ReadJson(const std::filesystem::path& file) {
  std::ifstream in(file);
  return tools::Json::parse(in);
}

TEST(KittiDataset, RefinedCalibrationBringsTheDriftBelowOnePercent) {
  const std::filesystem::path source = importer::SharedData() / "kitti_stereo_51";
  if (importer::SharedData().empty() || !std::filesystem::exists(source)) {
    GTEST_SKIP()
        << "no recording kitti_stereo_51; set GW_SHARED_DIR to the shared folder that holds "
           "data/kitti_stereo_51";
  }
  const importer::TestFolder folder;
  const std::string at = folder.path().string() + "/";
  ASSERT_EQ(RunProgram("gw-import kitti " + source.string() + " --out " + at +
                       "k.lcm --config-out " + at + "k.yaml --ground-truth-out " + at + "gt.tum"),
            0);
  ASSERT_EQ(RunProgram("gw-calibrate-stereo " + at + "k.lcm --config " + at +
                       "k.yaml --config-out " + at + "refined.yaml"),
            0);
  ASSERT_EQ(RunProgram("gw-slam " + at + "k.lcm --config " + at + "refined.yaml --out " + at +
                       "out --variant none"),
            0);
  ASSERT_EQ(RunProgram("gw-eval --ref " + at + "gt.tum --est " + at +
                       "out/trajectory.tum --align none --json " + at + "eval.json"),
            0);
  const tools::Json eval = ReadJson(at + "eval.json");
  EXPECT_EQ(eval["estimate_poses"], 51);
  EXPECT_LT(eval["drift"]["final_percent"].get<double>(), 1.0);
}

}  // namespace
}  // namespace gw::tools

#include "tools/lab/bench_suite/find.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tools/data/files/text_file.h"

namespace gw::bench {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

void Put(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  ASSERT_TRUE(tools::WriteTextFile(path, text).ok());
}

TEST(FindCidSims, KnowsMountsAndLeavesOutWhatHasNoWheels) {
  const fs::path data = testing::TempDir() + "gw_find_cid_sims";
  fs::remove_all(data);
  Put(data / "calibration.yaml", "x");
  for (const char* sequence : {"office/floor3_1", "apartment/apartment1_1", "office/downstairs"}) {
    Put(data / sequence / "associations.txt", "x");
    Put(data / sequence / "color/associations.txt", "an image folder is not looked into");
  }
  Put(data / "apartment/calibration.yaml", "x");
  Put(data / "apartment/apartment1_1/odom.txt", "# t px\n1 2\n");
  Put(data / "office/floor3_1/odom.txt", "1 2\n");
  Put(data / "office/downstairs/odom.txt", "# t px py pz\n\n");
  std::vector<SuiteInput> inputs;
  std::vector<std::string> left_out;
  ASSERT_TRUE(FindCidSims({true, {"apartment1_1"}}, data, &inputs, &left_out).ok());
  EXPECT_THAT(left_out, ElementsAre("downstairs"));
  ASSERT_EQ(inputs.size(), 2u);
  EXPECT_EQ(inputs[0].name, "apartment1_1");
  EXPECT_EQ(inputs[0].format, "cid-sims");
  EXPECT_EQ(inputs[0].path, data / "apartment/apartment1_1");
  EXPECT_THAT(inputs[0].options, ElementsAre("--mount", "low", "--calibration",
                                             (data / "apartment/calibration.yaml").string()));
  EXPECT_THAT(inputs[1].options, ElementsAre("--mount", "high", "--calibration",
                                             (data / "calibration.yaml").string()));

  fs::remove(data / "calibration.yaml");
  const auto missing = FindCidSims({true, {}}, data, &inputs, &left_out);
  ASSERT_FALSE(missing.ok());
  EXPECT_THAT(missing.error().message, HasSubstr("no calibration.yaml there or above"));
  fs::create_directories(data / "empty");
  const auto none = FindCidSims({true, {}}, data / "empty", &inputs, &left_out);
  ASSERT_FALSE(none.ok());
  EXPECT_THAT(none.error().message, HasSubstr("no sequence of CID-SIMS"));
  EXPECT_FALSE(FindCidSims({true, {}}, "", &inputs, &left_out).ok());
  EXPECT_FALSE(FindCidSims({true, {}}, "/no/such/folder", &inputs, &left_out).ok());
}

}  // namespace
}  // namespace gw::bench

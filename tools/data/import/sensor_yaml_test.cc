#include "tools/data/import/sensor_yaml.h"

#include <gmock/gmock.h>

#include "tools/data/import/test_folder.h"

namespace gw::importer {
namespace {

using testing::HasSubstr;

TEST(SensorYaml, ReadsTheHeaderTagsAndTabsOfOpenCv) {
  const TestFolder folder;
  folder.Write("c.yaml",
               "%YAML:1.0\nk: !!opencv-matrix\n  rows: 1\n  cols: 2\n  dt: d\n"
               "  data: [1.5,\n\t2e1]\nplain: [3, 4]\nn: -0.5 # comment\n");
  const auto yaml = SensorYaml::Read(folder.path() / "c.yaml", "a calibration");
  ASSERT_TRUE(yaml) << yaml.error().message;
  EXPECT_EQ(*yaml->Numbers("k", 2), (std::vector<double>{1.5, 20}));
  EXPECT_EQ(*yaml->Numbers("plain", 0), (std::vector<double>{3, 4}));
  EXPECT_EQ(*yaml->Number("n"), -0.5);
}

TEST(SensorYaml, NamesFileLineAndKeyOfMistakes) {
  const TestFolder folder;
  folder.Write("c.yaml", "%YAML:1.0\na: [1, 2]\nb: text\nT: [1, 2]\nn: .nan\n");
  const auto yaml = SensorYaml::Read(folder.path() / "c.yaml", "a calibration");
  ASSERT_TRUE(yaml);
  const std::string file = (folder.path() / "c.yaml").string();
  EXPECT_THAT(yaml->Numbers("a", 3).error().message, HasSubstr(file + ":2: a: "));
  EXPECT_THAT(yaml->Number("b").error().message, HasSubstr(file + ":3: b: "));
  EXPECT_THAT(yaml->Number("n").error().message, HasSubstr(file + ":5: n: "));
  EXPECT_THAT(yaml->Number("gone").error().message, HasSubstr("gone: is missing"));
  std::vector<std::string> warnings;
  EXPECT_FALSE(yaml->Pose("T", warnings));
}

TEST(SensorYaml, RefusesBrokenSyntaxWithItsLine) {
  const TestFolder folder;
  folder.Write("c.yaml", "a: 1\nb: [1, 2\nc: 3\n");
  const auto yaml = SensorYaml::Read(folder.path() / "c.yaml", "a calibration");
  ASSERT_FALSE(yaml);
  EXPECT_THAT(yaml.error().message, HasSubstr("c.yaml:"));
  EXPECT_EQ(SensorYaml::Read(folder.path() / "x.yaml", "x").error().code, ErrorCode::kNotFound);
}

TEST(SensorYaml, ReplacesASkewedRotationAndWarns) {
  const TestFolder folder;
  folder.Write("c.yaml",
               "exact: [1,0,0,1, 0,1,0,2, 0,0,1,3, 0,0,0,1]\n"
               "skewed: [1,0.008,0,1, 0,1,0,2, 0,0,1,3, 0,0,0,1]\n"
               "mirrored: [-1,0,0,1, 0,1,0,2, 0,0,1,3, 0,0,0,1]\n"
               "scaled: [2,0,0,1, 0,2,0,2, 0,0,2,3, 0,0,0,1]\n"
               "projective: [1,0,0,1, 0,1,0,2, 0,0,1,3, 0,0,1,1]\n");
  const auto yaml = SensorYaml::Read(folder.path() / "c.yaml", "a calibration");
  ASSERT_TRUE(yaml);
  std::vector<std::string> warnings;
  const auto exact = yaml->Pose("exact", warnings);
  ASSERT_TRUE(exact);
  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(exact->translation(), Eigen::Vector3d(1, 2, 3));
  const auto skewed = yaml->Pose("skewed", warnings);
  ASSERT_TRUE(skewed);
  EXPECT_THAT(AllText(warnings), HasSubstr("skewed: rotation is off orthonormal by 0.008"));
  // A shear of 0.008 is half rotation, half strain.
  EXPECT_NEAR(LogSO3(skewed->rotation()).z(), -0.004, 1e-5);
  EXPECT_FALSE(yaml->Pose("mirrored", warnings));
  EXPECT_FALSE(yaml->Pose("scaled", warnings));
  EXPECT_FALSE(yaml->Pose("projective", warnings));
}

TEST(BodyAtCamera, LooksForwardWithZUp) {
  const SE3 T_BC = PoseOfBodyAtCamera();
  EXPECT_TRUE((T_BC * Eigen::Vector3d(0, 0, 1)).isApprox(Eigen::Vector3d(1, 0, 0), 1e-12));
  EXPECT_TRUE((T_BC * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(0, -1, 0), 1e-12));
  EXPECT_TRUE((T_BC * Eigen::Vector3d(0, 1, 0)).isApprox(Eigen::Vector3d(0, 0, -1), 1e-12));
}

}  // namespace
}  // namespace gw::importer

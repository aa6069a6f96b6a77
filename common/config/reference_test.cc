#include "common/config/reference.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace gw {
namespace {

TEST(Reference, CommittedPageIsUpToDate) {
  std::ifstream file(GW_SOURCE_DIR "/docs/configuration.md");
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), ConfigReference())
      << "run: gw-config --doc > docs/configuration.md, and commit it with the changed field";
}

void ExpectExplained(const FieldInfo& section, const std::string& path) {
  for (const FieldInfo& field : section.fields) {
    EXPECT_STRNE(field.spec.text, "") << path << field.name << " has no explanation";
    if (field.type == "int") {
      EXPECT_NE(LegalRange(field.spec), "") << path << field.name << " has no range";
    }
    ExpectExplained(field, path + field.name + ".");
  }
}

TEST(Reference, EveryKeyIsExplained) {
  ExpectExplained(DescribeConfig(RobotConfig{}), "");
}

}  // namespace
}  // namespace gw

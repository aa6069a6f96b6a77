#include "common/config/reference.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace gw {
namespace {

TEST(Reference, CommittedPageIsUpToDate) {
  std::ifstream committed(GW_SOURCE_DIR "/docs/configuration.md");
  std::istringstream generated(ConfigReference());
  std::string have;
  std::string want;
  for (int line = 1;; ++line) {
    const bool more_have = static_cast<bool>(std::getline(committed, have));
    const bool more_want = static_cast<bool>(std::getline(generated, want));
    ASSERT_TRUE(more_have == more_want && have == want)
        << "docs/configuration.md:" << line << " is\n  " << have << "\nand should be\n  " << want
        << "\nrun: gw-config --doc > docs/configuration.md, and commit it with the changed field";
    if (!more_have) break;
  }
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

#include "tools/data/files/shell_word.h"

#include <gtest/gtest.h>

namespace gw::tools {
namespace {

TEST(ShellWord, IsQuotedWhereItMustBe) {
  EXPECT_EQ(ShellWord("paper:full+corners"), "paper:full+corners");
  EXPECT_EQ(ShellWord(""), "''");
  EXPECT_EQ(ShellWord("^a$"), "'^a$'");
  EXPECT_EQ(ShellWord("it's"), R"('it'\''s')");
}

}  // namespace
}  // namespace gw::tools

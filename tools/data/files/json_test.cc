#include "tools/data/files/json.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gw::tools {
namespace {

TEST(Json, KeepsTheOrderOfKeys) {
  EXPECT_EQ(JsonLine({{"b", 1}, {"a", true}}), "{\"b\":1,\"a\":true}\n");
  EXPECT_EQ(JsonDocument({{"b", 1}, {"a", 0.5}}), "{\n  \"b\": 1,\n  \"a\": 0.5\n}\n");
}

TEST(Json, EscapesWhatJsonForbids) {
  EXPECT_EQ(JsonLine("a\"b\\c\n\x01 \xC3\xA4"), "\"a\\\"b\\\\c\\n\\u0001 \xC3\xA4\"\n");
}

TEST(Json, WritesWhatJsonHasNoTextFor) {
  EXPECT_EQ(JsonLine("\xFF"), "\"\xEF\xBF\xBD\"\n");
  EXPECT_EQ(JsonLine(NAN), "null\n");
  EXPECT_EQ(JsonLine(ValueOrNull(std::optional<double>())), "null\n");
  EXPECT_EQ(JsonLine(ValueOrNull(std::optional(0.25))), "0.25\n");
}

}  // namespace
}  // namespace gw::tools

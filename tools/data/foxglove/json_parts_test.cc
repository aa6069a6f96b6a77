#include "tools/data/foxglove/json_parts.h"

#include <gtest/gtest.h>

#include "tools/data/files/json.h"

namespace gw::foxglove {
namespace {

std::string Encoded(std::string_view text) {
  return Base64({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

// The examples of RFC 4648, section 10.
TEST(JsonParts, Base64IsThatOfTheStandard) {
  EXPECT_EQ(Encoded(""), "");
  EXPECT_EQ(Encoded("f"), "Zg==");
  EXPECT_EQ(Encoded("fo"), "Zm8=");
  EXPECT_EQ(Encoded("foo"), "Zm9v");
  EXPECT_EQ(Encoded("foob"), "Zm9vYg==");
  EXPECT_EQ(Encoded("foobar"), "Zm9vYmFy");
}

TEST(JsonParts, TimeIsSecondsAndNanoseconds) {
  EXPECT_EQ(JsonTime({1'500'000'123}).dump(), R"({"sec":1500,"nsec":123000})");
  EXPECT_EQ(JsonTime({-5}).dump(), R"({"sec":0,"nsec":0})");
}

TEST(JsonParts, PackedFloatsAreLittleEndian) {
  PackedElements packed;
  packed.AddFloat(1.0F);  // 0x3F800000
  EXPECT_EQ(packed.base64(), "AACAPw==");
}

}  // namespace
}  // namespace gw::foxglove

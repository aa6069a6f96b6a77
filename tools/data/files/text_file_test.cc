#include "tools/data/files/text_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tools/data/files/hash_file.h"

namespace gw::tools {
namespace {

using testing::HasSubstr;

TEST(TextFile, ComesBackAsItWasWritten) {
  const std::string path = testing::TempDir() + "gw_text_file";
  for (const std::string& text : {std::string("a\nb\r\n\0c", 7), std::string()}) {
    ASSERT_TRUE(WriteTextFile(path, text).ok());
    const auto read = ReadTextFile(path);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(*read, text);
  }
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
}

TEST(HashFile, IsFnv1aOfTheBytes) {
  const std::string path = testing::TempDir() + "gw_hash_file";
  ASSERT_TRUE(WriteTextFile(path, "foobar").ok());
  const auto hash = HashFile(path);
  ASSERT_TRUE(hash.ok());
  EXPECT_EQ(HashText(*hash), "85944171f73967e8");  // from the authors' test vectors
  EXPECT_EQ(HashFile("/no/such/file").error().code, ErrorCode::kNotFound);
}

TEST(TextFile, ErrorsNameThePathAndTheReason) {
  const auto read = ReadTextFile("/no/such/file");
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(read.error().message, HasSubstr("/no/such/file: cannot open: No such file"));
  const auto written = WriteTextFile("/no/such/folder/file", "x");
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().code, ErrorCode::kIo);
  EXPECT_THAT(written.error().message, HasSubstr("/no/such/folder/file"));
}

}  // namespace
}  // namespace gw::tools

// The structure of MCAP files, read back by a second, independent reading of the specification
// (https://mcap.dev/spec). tools/view/page/test reads them with @mcap/core where npm is there.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "tools/data/foxglove/mcap_writer.h"

namespace gw::foxglove {
namespace {

class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : rest_(bytes) {}
  template <typename U>
  U Number() {
    uint64_t value = 0;
    for (size_t i = 0; i < sizeof(U); ++i) {
      value |= uint64_t{static_cast<uint8_t>(rest_[i])} << (8 * i);
    }
    rest_.remove_prefix(sizeof(U));
    return static_cast<U>(value);
  }
  std::string_view Raw(size_t n) {
    const auto bytes = rest_.substr(0, n);
    rest_.remove_prefix(n);
    return bytes;
  }
  std::string_view Text() { return Raw(Number<uint32_t>()); }
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

std::string WriteExample(const std::string& path, int messages) {
  auto writer = McapWriter::Create(path);
  EXPECT_TRUE(writer.ok());
  const uint16_t schema = writer->AddSchema("gw.Test", "jsonschema", "{}");
  const uint16_t channel = writer->AddChannel(schema, "/test", "json");
  for (int i = 0; i < messages; ++i) {
    EXPECT_TRUE(writer->Write(channel, 1000u + i, std::string(10'000, 'x')).ok());
  }
  EXPECT_TRUE(writer->Close().ok());
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string TemporaryPath() {
  return testing::TempDir() + "gw_foxglove.mcap";
}

TEST(Mcap, FooterLeadsToSummaryAndEveryMessageIsIndexed) {
  constexpr int kMessages = 300;  // three chunks
  const std::string bytes = WriteExample(TemporaryPath(), kMessages);
  const std::string magic("\x89MCAP0\r\n", 8);
  ASSERT_EQ(bytes.substr(0, 8), magic);
  ASSERT_EQ(bytes.substr(bytes.size() - 8), magic);
  const size_t footer_at = bytes.size() - 8 - 29;
  Cursor footer(std::string_view(bytes).substr(footer_at));
  ASSERT_EQ(footer.Number<uint8_t>(), 0x02);
  ASSERT_EQ(footer.Number<uint64_t>(), 20u);
  const auto summary_start = footer.Number<uint64_t>();
  footer.Number<uint64_t>();
  EXPECT_EQ(footer.Number<uint32_t>(),
            Crc32(std::string_view(bytes).substr(summary_start, footer_at + 25 - summary_start)));

  int chunks = 0, indexed = 0;
  uint64_t counted = 0;
  for (Cursor at(std::string_view(bytes).substr(summary_start, footer_at - summary_start));
       !at.rest().empty();) {
    const auto opcode = at.Number<uint8_t>();
    Cursor record(at.Raw(at.Number<uint64_t>()));
    if (opcode == 0x0B) counted = record.Number<uint64_t>();
    if (opcode != 0x08) continue;
    ++chunks;
    record.Number<uint64_t>();
    record.Number<uint64_t>();
    const auto offset = record.Number<uint64_t>();
    const auto length = record.Number<uint64_t>();
    Cursor chunk(std::string_view(bytes).substr(offset, length));
    EXPECT_EQ(chunk.Number<uint8_t>(), 0x06);
    EXPECT_EQ(chunk.Number<uint64_t>(), length - 9);
    Cursor offsets(record.Raw(record.Number<uint32_t>()));
    while (!offsets.rest().empty()) {
      offsets.Number<uint16_t>();
      Cursor index(std::string_view(bytes).substr(offsets.Number<uint64_t>()));
      EXPECT_EQ(index.Number<uint8_t>(), 0x07);
      index.Number<uint64_t>();
      index.Number<uint16_t>();
      indexed += static_cast<int>(index.Number<uint32_t>() / 16);
    }
  }
  EXPECT_EQ(chunks, 3);
  EXPECT_EQ(indexed, kMessages);
  EXPECT_EQ(counted, static_cast<uint64_t>(kMessages));
}

TEST(Mcap, AFileThatCannotBeMadeIsAnError) {
  EXPECT_FALSE(McapWriter::Create("/nonexistent/folder/x.mcap").ok());
}

// Example value of the CRC-32 of IEEE 802.3: "123456789".
TEST(Mcap, CrcIsThatOfTheStandard) {
  EXPECT_EQ(Crc32("123456789"), 0xCBF43926u);
}

}  // namespace
}  // namespace gw::foxglove

#include "tools/data/import/text_table.h"

#include <gmock/gmock.h>

#include "tools/data/import/streams.h"
#include "tools/data/import/test_folder.h"

namespace gw::importer {
namespace {

using testing::HasSubstr;

struct Stamped {
  Utime utime;
  int tag;
};

TEST(TextTable, SkipsCommentsAndSplitsAtBlanksAndCommas) {
  const TestFolder folder;
  folder.Write("t.txt", "# a comment\r\n\n  1.5, 2\t+3e0\r\n#x\n4 5 6\n");
  const auto table = TextTable::Read(folder.path() / "t.txt", "numbers");
  ASSERT_TRUE(table);
  ASSERT_EQ(table->rows().size(), 2u);
  EXPECT_EQ(table->rows()[0].line(), 3);
  EXPECT_EQ(*table->rows()[0].Numbers(0, 3), (std::vector<double>{1.5, 2, 3}));
  EXPECT_EQ(table->rows()[1].line(), 5);
}

TEST(TextTable, NothingBetweenCommasIsAFieldOfItsOwn) {
  const TestFolder folder;
  folder.Write("t.csv", "1,,3,4\n,2,3,4\n1, ,3,\n,,,\n\"\",2\n");
  const auto table = TextTable::Read(folder.path() / "t.csv", "numbers");
  ASSERT_TRUE(table);
  ASSERT_EQ(table->rows().size(), 4u) << "commas alone are an empty line";
  EXPECT_EQ(table->rows()[0].size(), 4u);
  EXPECT_EQ(*table->rows()[0].Number(2), 3);
  EXPECT_EQ(table->rows()[1].size(), 4u);
  EXPECT_EQ(table->rows()[2].size(), 3u) << "a comma at the end adds none";
  for (size_t row = 0; row < 4; ++row) EXPECT_TRUE(table->rows()[row].HasNoValue(0, 4)) << row;
  EXPECT_FALSE(table->rows()[0].HasNoValue(2, 2));
}

TEST(TextTable, WordsForNoMeasurementAreKnown) {
  const TestFolder folder;
  folder.Write("t.csv",
               "1 null\n1 NULL\n1 None\n1 nan\n1 -nan\n1 NaN\n1 inf\n1 NA\n1 N/A\n1 nano\n");
  const auto table = TextTable::Read(folder.path() / "t.csv", "numbers");
  ASSERT_TRUE(table);
  for (const TextRow& row : table->rows()) {
    EXPECT_EQ(row.HasNoValue(0, 2), row.text(1) != "nano") << row.text(1);
  }
}

TEST(TextTable, AHeadingWithoutHashIsNoRecord) {
  const TestFolder folder;
  folder.Write("t.csv", "\xEF\xBB\xBFtimestamp,x\r\n1,2\r\n");
  const auto table = TextTable::Read(folder.path() / "t.csv", "numbers");
  ASSERT_TRUE(table);
  ASSERT_EQ(table->rows().size(), 1u);
  EXPECT_EQ(table->rows()[0].line(), 2);
  folder.Write("t.csv", "P0: 1\nP1: 2\n");
  EXPECT_EQ(TextTable::Read(folder.path() / "t.csv", "numbers")->rows().size(), 2u);
}

TEST(TextTable, NamesBehindTheTimeAreKeptAsTheyAreWritten) {
  const TestFolder folder;
  folder.Write("t.txt", "1 a  b,c.png \r\n1,\"a b.png\"\n1\ta\\b.png\n1, x.png, more\n1\n");
  const auto table = TextTable::Read(folder.path() / "t.txt", "names");
  ASSERT_TRUE(table);
  EXPECT_EQ(table->rows()[0].after_first(), "a  b,c.png");
  EXPECT_EQ(table->rows()[1].after_first(), "a b.png");
  EXPECT_EQ(table->rows()[2].after_first(), "a\\b.png");
  EXPECT_EQ(table->rows()[3].after_first(), "x.png, more");
  EXPECT_EQ(table->rows()[4].after_first(), "");
}

TEST(TextTable, AllRowsThatAreRefusedAreNamedTogether) {
  const TestFolder folder;
  std::string text = "1\nx\n2\ny\n";
  folder.Write("t.txt", text);
  const auto numbers = [&](std::vector<std::string>& warnings) {
    const auto table = TextTable::Read(folder.path() / "t.txt", "numbers");
    return table->ForEach(warnings, [](const TextRow& row) -> Result<Done> {
      const auto number = row.Number(0);
      if (!number) return number.error();
      return Done{};
    });
  };
  std::vector<std::string> warnings;
  const Result<Done> two = numbers(warnings);
  ASSERT_FALSE(two);
  EXPECT_THAT(two.error().message,
              testing::AllOf(HasSubstr("t.txt:2: 'x'"), HasSubstr("t.txt:4: 'y'")));
  for (int i = 0; i < 100; ++i) text += "z\n";
  folder.Write("t.txt", text);
  EXPECT_THAT(numbers(warnings).error().message, HasSubstr("t.txt: 97 more lines like these"));
  EXPECT_TRUE(warnings.empty());
}

TEST(TextTable, ALastLineThatIsCutOffIsLeftOutWithAWarning) {
  const TestFolder folder;
  const auto read = [&](const char* text, std::vector<std::string>& warnings) {
    folder.Write("t.txt", text);
    return TextTable::Read(folder.path() / "t.txt", "pairs")
        ->ForEach(warnings, [](const TextRow& row) -> Result<Done> {
          const auto pair = row.Numbers(0, 2);
          if (!pair) return pair.error();
          return Done{};
        });
  };
  std::vector<std::string> warnings;
  EXPECT_TRUE(read("1 2\n3 4", warnings));
  EXPECT_TRUE(warnings.empty());
  EXPECT_TRUE(read("1 2\n3", warnings));
  EXPECT_THAT(AllText(warnings), HasSubstr("t.txt:2: "));
  EXPECT_FALSE(read("1 2\n3\n", warnings)) << "whole, but wrong";
}

TEST(TextTable, NamesFileLineAndRemedyForBadFields) {
  const TestFolder folder;
  folder.Write("t.txt", "1 2\nnan 1 abc 1e400 12x\n");
  const auto table = TextTable::Read(folder.path() / "t.txt", "numbers");
  ASSERT_TRUE(table);
  const std::string where = (folder.path() / "t.txt").string() + ":2: ";
  const TextRow& row = table->rows()[1];
  for (const size_t field : {0u, 2u, 3u, 4u, 5u}) {
    const auto number = row.Number(field);
    ASSERT_FALSE(number) << field;
    EXPECT_THAT(number.error().message, testing::StartsWith(where)) << field;
    EXPECT_EQ(number.error().code, ErrorCode::kBadData);
  }
}

TEST(TextTable, RefusesMissingAndEmptyFiles) {
  const TestFolder folder;
  const auto missing = TextTable::Read(folder.path() / "t.txt", "poses");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().message, HasSubstr("poses"));
  folder.Write("t.txt", "# nothing\n");
  const auto empty = TextTable::Read(folder.path() / "t.txt", "poses");
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().code, ErrorCode::kBadData);
}

TEST(TextTable, KeepsMicrosecondsOfUnixTimesExact) {
  const TestFolder folder;
  folder.Write("t.txt", "1305031229.528748\n1560000061.99999951\n1e18\n1.403715273262142976e18\n");
  const auto table = TextTable::Read(folder.path() / "t.txt", "times");
  ASSERT_TRUE(table);
  EXPECT_EQ(table->rows()[0].Seconds(0)->us, 1305031229528748);
  EXPECT_EQ(table->rows()[1].Seconds(0)->us, 1560000062000000);
  EXPECT_FALSE(table->rows()[2].Seconds(0));      // nanoseconds given as seconds
  EXPECT_FALSE(table->rows()[3].Nanoseconds(0));  // not a whole number
  EXPECT_EQ(UtimeFromNanoseconds(1403715273262142976).us, 1403715273262143);
}

TEST(TextTable, RefusesAQuaternionOfWrongLength) {
  const TestFolder folder;
  folder.Write("t.txt", "0 0 0 0 0 0 0 0.5\n0 1 2 3 0 0 0 1.01\n");
  const auto table = TextTable::Read(folder.path() / "t.txt", "poses");
  ASSERT_TRUE(table);
  EXPECT_FALSE(table->rows()[0].PoseXyzQxyzw(1));
  EXPECT_TRUE(table->rows()[1].PoseXyzQxyzw(1));
}

TEST(Streams, SortsAndDropsRepeatedTimesKeepingTheFirst) {
  std::vector<Stamped> samples = {{{3}, 0}, {{1}, 1}, {{3}, 2}, {{2}, 3}, {{1}, 4}};
  std::vector<std::string> warnings;
  ASSERT_TRUE(MakeOrdered(samples, "f.txt", warnings));
  ASSERT_EQ(samples.size(), 3u);
  EXPECT_EQ(samples[0].tag, 1);
  EXPECT_EQ(samples[1].tag, 3);
  EXPECT_EQ(samples[2].tag, 0);
  EXPECT_THAT(AllText(warnings), HasSubstr("f.txt: 2 of 5 records repeat"));
}

TEST(Streams, AssociatesEachWithItsNearestWithinTheLimit) {
  // b[0] serves a[0] and a[1]. 20 ms apart is too far.
  const std::vector<Utime> a = {{0}, {12000}, {100000}, {200000}};
  const std::vector<Utime> b = {{10000}, {25000}, {120000}, {199000}};
  using Pairs = std::vector<std::pair<size_t, size_t>>;
  EXPECT_EQ(AssociateNearest(a, b, Milliseconds(20)), (Pairs{{0, 0}, {1, 0}, {3, 3}}));
  EXPECT_TRUE(AssociateNearest(a, {}, Milliseconds(20)).empty());
}

TEST(Streams, MedianRateIgnoresAGap) {
  EXPECT_NEAR(MedianRateHz({{0}, {33333}, {66666}, {99999}, {500000}}), 30.0, 0.01);
  EXPECT_EQ(MedianRateHz({{5}}), 0);
}

}  // namespace
}  // namespace gw::importer

// Bags written by the libraries that robots use (testing/make_bags.py), whole and damaged.
#include "tools/data/bag/bag.h"

#include <gmock/gmock.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "common/core/random.h"
#include "tools/data/bag/decompress.h"
#include "tools/data/bag/mcap.h"
#include "tools/data/bag/ros1_bag.h"
#include "tools/data/bag/sqlite_bag.h"

namespace gw::bag {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

const fs::path kBags = fs::path(GW_SOURCE_DIR) / "tools/data/bag/testing/bags";
constexpr const char* kAll[] = {
    "ros1_none.bag", "ros1_bz2.bag",   "ros1_lz4.bag",   "none.mcap", "zstd.mcap",
    "lz4.mcap",      "unchunked.mcap", "unindexed.mcap", "rosbag2",   "rosbag2/rosbag2_0.db3"};
constexpr size_t kMessages = 22;

std::vector<uint8_t> BytesOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class BagTest : public testing::Test {
 protected:
  fs::path Write(const std::string& name, Bytes bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << TextOf(bytes);
    return folder_ / name;
  }
  // Name of what a bag that is opened holds, its warnings, or the error.
  static std::string Text(const fs::path& path) {
    const auto bag = Bag::Open(path);
    if (!bag) return bag.error().message;
    std::string text = std::to_string((*bag)->messages().size()) + " messages\n";
    for (const std::string& warning : (*bag)->warnings()) text += warning + "\n";
    return text;
  }
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "gw_bag_XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
};

TEST_F(BagTest, EveryContainerAndCompressionHoldsTheSame) {
  std::map<Serialization, std::vector<std::vector<uint8_t>>> contents;
  for (const char* name : kAll) {
    SCOPED_TRACE(name);
    const auto bag = Bag::Open(kBags / name);
    ASSERT_TRUE(bag) << bag.error().message;
    EXPECT_THAT((*bag)->warnings(), IsEmpty());
    ASSERT_EQ((*bag)->topics().size(), 8u);
    ASSERT_EQ((*bag)->messages().size(), kMessages);
    EXPECT_EQ((*bag)->messages().front().log_ns, 100'000'000'000);
    EXPECT_EQ((*bag)->messages().back().log_ns, 100'200'000'000);
    std::vector<std::vector<uint8_t>> all;
    for (const MessageRef& ref : (*bag)->messages()) {
      const Topic& topic = (*bag)->topics()[ref.topic];
      if (topic.name == "/imu") {
        EXPECT_EQ(topic.type, "sensor_msgs/Imu");
        EXPECT_EQ(topic.messages, 3);
      }
      const auto bytes = (*bag)->Read(ref);
      ASSERT_TRUE(bytes);
      all.emplace_back(bytes->begin(), bytes->end());
    }
    auto& expected = contents[(*bag)->topics()[0].serialization];
    if (expected.empty()) expected = all;
    EXPECT_EQ(all, expected);
  }
  EXPECT_EQ(contents.size(), 2u);  // ROS 1 and CDR
}

TEST_F(BagTest, WhatIsCutOffIsReadAsFarAsItGoes) {
  for (const char* name : kAll) {
    if (fs::is_directory(kBags / name) || fs::path(name).extension() == ".db3") continue;
    SCOPED_TRACE(name);
    const std::vector<uint8_t> whole = BytesOf(kBags / name);
    size_t before = 0;
    for (const double share : {0.2, 0.5, 0.7, 0.9}) {
      const auto size = static_cast<size_t>(share * static_cast<double>(whole.size()));
      const auto bag = Bag::Open(Write("cut", Bytes(whole).first(size)));
      ASSERT_TRUE(bag);
      EXPECT_GE((*bag)->messages().size(), before);
      before = (*bag)->messages().size();
      for (const MessageRef& ref : (*bag)->messages()) EXPECT_TRUE((*bag)->Read(ref));
      if (before < kMessages) {
        EXPECT_FALSE((*bag)->warnings().empty());
      }
    }
  }
  const std::vector<uint8_t> plain = BytesOf(kBags / "unchunked.mcap");
  EXPECT_THAT(Text(Write("half.mcap", Bytes(plain).first(plain.size() / 2))),
              HasSubstr("was not closed"));
  // A chunk that ends early gives what could be decompressed of it.
  const std::vector<uint8_t> zstd = BytesOf(kBags / "ros1_none.bag");
  EXPECT_THAT(Text(Write("half.bag", Bytes(zstd).first(70000))), HasSubstr("ends within"));
}

TEST_F(BagTest, ABagWithoutIndexIsReadAndSaid) {
  // As the recorder leaves it when it is killed: the header does not know where the index is.
  std::vector<uint8_t> bytes = BytesOf(kBags / "ros1_none.bag");
  const std::string field = "index_pos=";
  const auto at = std::search(bytes.begin(), bytes.end(), field.begin(), field.end());
  ASSERT_NE(at, bytes.end());
  std::fill_n(at + static_cast<int64_t>(field.size()), 8, uint8_t{0});
  const std::string text = Text(Write("r.bag.active", bytes));
  EXPECT_THAT(text, HasSubstr("22 messages"));
  EXPECT_THAT(text, HasSubstr("was not closed"));
}

TEST_F(BagTest, WhatIsNoBagIsNamed) {
  EXPECT_THAT(Text(folder_ / "absent"), HasSubstr("not there"));
  EXPECT_THAT(Text(Write("empty.bag", {})), HasSubstr("is empty"));
  const auto text = [&](const std::string& content) {
    return Text(Write("x", {reinterpret_cast<const uint8_t*>(content.data()), content.size()}));
  };
  EXPECT_THAT(text("#ROSBAG V1.2\n"), HasSubstr("rosbag migrate"));
  EXPECT_THAT(text("hello"), HasSubstr("neither a ROS 1 bag nor MCAP nor a database"));
  EXPECT_THAT(text("\x28\xb5\x2f\xfd and more"), HasSubstr("zstd -d"));
  EXPECT_THAT(text("#ROSBAG V2.0\n"), HasSubstr("0 messages\n"));
  EXPECT_THAT(text("\x89MCAP0\r\n"), HasSubstr("0 messages"));
  fs::create_directory(folder_ / "sub");
  EXPECT_THAT(Text(folder_ / "sub"), HasSubstr("holds no .db3, .mcap or .bag"));
}

TEST_F(BagTest, AFolderInSeveralFilesWithoutMetadata) {
  fs::copy_file(kBags / "zstd.mcap", folder_ / "a_10.mcap");
  fs::copy_file(kBags / "zstd.mcap", folder_ / "a_9.mcap");
  const auto bag = Bag::Open(folder_);
  ASSERT_TRUE(bag) << bag.error().message;
  EXPECT_EQ((*bag)->topics().size(), 8u);
  EXPECT_EQ((*bag)->messages().size(), 2 * kMessages);
  EXPECT_EQ((*bag)->messages().back().file, 1u);
  EXPECT_THAT((*bag)->warnings(), testing::ElementsAre(HasSubstr("metadata.yaml is not there")));
}

TEST_F(BagTest, DamagedDatabasesAndDatabasesOfOthers) {
  const std::vector<uint8_t> whole = BytesOf(kBags / "rosbag2/rosbag2_0.db3");
  // Its first pages are whole: the rest is counted as lost, or the file is refused.
  const auto cut = Bag::Open(Write("cut.db3", Bytes(whole).first(40000)));
  ASSERT_FALSE(!cut && cut.error().message.empty());
  if (cut) {
    EXPECT_FALSE((*cut)->warnings().empty());
  }
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open((folder_ / "other.db3").c_str(), &other), SQLITE_OK);
  sqlite3_exec(other, "CREATE TABLE notes(id INTEGER)", nullptr, nullptr, nullptr);
  sqlite3_close(other);
  EXPECT_THAT(Text(folder_ / "other.db3"), HasSubstr("no database of rosbag2"));
}

TEST(Decompress, ALengthThatIsTooSmallBoundsTheResult) {
  const std::vector<uint8_t> mcap = BytesOf(kBags / "zstd.mcap");
  const std::array<uint8_t, 4> magic = {0x28, 0xb5, 0x2f, 0xfd};
  const auto at = std::search(mcap.begin(), mcap.end(), magic.begin(), magic.end());
  ASSERT_NE(at, mcap.end());
  const Decompressed out =
      Decompress("zstd", Bytes(mcap).subspan(static_cast<size_t>(at - mcap.begin())), 100);
  EXPECT_EQ(out.bytes.size(), 100u);
  EXPECT_FALSE(out.problem.empty());
  EXPECT_FALSE(Decompress("snappy", mcap, 100).problem.empty());
}

// Bytes of whole bags, spoilt at random: whatever comes out, it can be read without a crash. Ten
// million bytes per reader, when they are run under the sanitizers.
TEST_F(BagTest, SpoiltBytesAreReadQuietly) {
  for (const char* name : {"ros1_lz4.bag", "ros1_none.bag", "zstd.mcap", "lz4.mcap", "none.mcap"}) {
    const std::vector<uint8_t> whole = BytesOf(kBags / name);
    for (uint64_t run = 0; run * whole.size() < 5'000'000 && run < 300; ++run) {
      CounterRng rng(23, run, whole.size());
      std::vector<uint8_t> bytes = whole;
      for (uint64_t k = rng.Below(20) + 1; k > 0; --k) {
        bytes[50 + rng.Below(bytes.size() - 50)] = static_cast<uint8_t>(rng.Below(256));
      }
      bytes.resize(bytes.size() - rng.Below(2) * rng.Below(bytes.size() / 2));
      const auto file = IsMcap(bytes) ? ReadMcap(bytes) : ReadRos1Bag(bytes);
      for (const MessageRef& ref : file->messages()) (void)file->Read(ref).ok();
    }
  }
  const std::vector<uint8_t> database = BytesOf(kBags / "rosbag2/rosbag2_0.db3");
  for (uint64_t run = 0; run < 40; ++run) {
    CounterRng rng(24, run, 0);
    std::vector<uint8_t> bytes = database;
    for (int k = 0; k < 20; ++k) {
      bytes[100 + rng.Below(bytes.size() - 100)] = static_cast<uint8_t>(rng.Below(256));
    }
    const auto file = ReadSqliteBag(Write("s.db3", bytes), false);
    if (!file) continue;
    for (const MessageRef& ref : (*file)->messages()) (void)(*file)->Read(ref).ok();
  }
}

}  // namespace
}  // namespace gw::bag

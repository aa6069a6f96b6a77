#include "tools/robot/record/segment_log.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tools/data/import/test_folder.h"

namespace gw::record {
namespace {

namespace fs = std::filesystem;

std::vector<uint8_t> Message(int64_t i, size_t size = 1000) {
  return std::vector<uint8_t>(size, static_cast<uint8_t>(i));
}

std::vector<fs::path> Files(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

// First byte of every message in the folder, in the order of the files.
std::vector<int> ReadAll(const fs::path& folder) {
  std::vector<int> all;
  for (const fs::path& file : Files(folder)) {
    auto log = process::EventLogReader::Open(file.string());
    while (const auto event = log->Next()) all.push_back(event->data[0]);
    EXPECT_EQ(log->skipped_bytes(), 0);
  }
  return all;
}

constexpr Utime kStart{1'764'101'283'000'000};
Utime At(int64_t i) {
  return kStart + Milliseconds(33 * i);
}

TEST(SegmentLog, LosesNothingAcrossFiles) {
  const importer::TestFolder folder;
  auto log = SegmentLog::Open(folder.path(), {.segment_bytes = 5000, .total_bytes = 1 << 20});
  ASSERT_TRUE(log);
  for (int64_t i = 0; i < 100; ++i) ASSERT_TRUE(log->Append(At(i), "CAMERA", Message(i)));
  ASSERT_TRUE(log->Close());
  EXPECT_EQ(Files(folder.path()).size(), 20U);  // five messages of 1034 bytes reach 5000
  const std::vector<int> all = ReadAll(folder.path());
  ASSERT_EQ(all.size(), 100U);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(all[static_cast<size_t>(i)], i);
}

TEST(SegmentLog, DeletesTheOldestFiles) {
  const importer::TestFolder folder;
  auto log = SegmentLog::Open(folder.path(), {.segment_bytes = 5000, .total_bytes = 20000});
  for (int64_t i = 0; i < 100; ++i) {
    ASSERT_TRUE(log->Append(At(i), "CAMERA", Message(i)));
    EXPECT_LE(log->bytes(), 20000 + 1034);
  }
  ASSERT_TRUE(log->Close());
  const std::vector<int> all = ReadAll(folder.path());
  EXPECT_EQ(all.back(), 99);
  EXPECT_GE(all.front(), 80);
  EXPECT_EQ(all.size(), static_cast<size_t>(100 - all.front()));
}

TEST(SegmentLog, FilesOfAnEarlierRunCountAndAreDeletedFirst) {
  const importer::TestFolder folder;
  const SegmentLimits limits{.segment_bytes = 5000, .total_bytes = 12000};
  {
    auto first = SegmentLog::Open(folder.path(), limits);
    for (int64_t i = 0; i < 8; ++i) ASSERT_TRUE(first->Append(At(i), "CAMERA", Message(i)));
  }  // without Close, as after a crash
  auto second = SegmentLog::Open(folder.path(), limits);
  EXPECT_EQ(second->bytes(), 8 * 1034);
  for (int64_t i = 8; i < 20; ++i) ASSERT_TRUE(second->Append(At(i), "CAMERA", Message(i)));
  ASSERT_TRUE(second->Close());
  const std::vector<int> all = ReadAll(folder.path());
  EXPECT_EQ(all.front(), 13);  // both files of the first run went, then one of the second
  EXPECT_EQ(all.back(), 19);
}

TEST(SegmentLog, TellsWhichFilesHoldARecentMoment) {
  const importer::TestFolder folder;
  auto log = SegmentLog::Open(folder.path(), {.segment_bytes = 5000, .total_bytes = 1 << 20});
  for (int64_t i = 0; i < 22; ++i) ASSERT_TRUE(log->Append(At(i), "CAMERA", Message(i)));
  EXPECT_EQ(log->FilesSince(At(0)).size(), 5U);
  EXPECT_EQ(log->FilesSince(At(4)).size(), 5U);  // the last message of the first file
  EXPECT_EQ(log->FilesSince(At(5)).size(), 4U);
  EXPECT_EQ(log->FilesSince(At(20)).size(), 1U);  // the current file
  EXPECT_EQ(log->FilesSince(At(22)).size(), 0U);
}

TEST(SegmentLog, GoesOnWhenTheDiskDoes) {
  const importer::TestFolder folder;
  const fs::path there = folder.path() / "mounted";
  fs::create_directory(there);
  auto log = SegmentLog::Open(there, {.segment_bytes = 2000, .total_bytes = 1 << 20});
  ASSERT_TRUE(log->Append(At(0), "CAMERA", Message(0)));
  ASSERT_TRUE(log->Append(At(1), "CAMERA", Message(1)));
  fs::rename(there, folder.path() / "gone");
  const auto lost = log->Append(At(2), "CAMERA", Message(2));
  ASSERT_FALSE(lost);
  EXPECT_NE(lost.error().message.find("mounted"), std::string::npos) << lost.error().message;
  fs::rename(folder.path() / "gone", there);
  EXPECT_TRUE(log->Append(At(3), "CAMERA", Message(3)));
  ASSERT_TRUE(log->Close());
  EXPECT_EQ(ReadAll(there), (std::vector<int>{0, 1, 3}));
}

TEST(FileStamp, SortsByTime) {
  EXPECT_EQ(FileStamp(kStart), "2025-11-25T20-08-03.000000");
  EXPECT_LT(FileStamp(At(1)), FileStamp(At(1000)));
}

}  // namespace
}  // namespace gw::record

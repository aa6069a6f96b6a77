// Small source folders for tests of the importers.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/data/import/recording.h"

namespace gw::importer {

// A folder of its own per test, removed at the end.
class TestFolder {
 public:
  TestFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "gw_test_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~TestFolder() { std::filesystem::remove_all(path_); }
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  void Write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name) << text;
  }
  // 80 x 64 grey whose pixel (x, y) is x + y + salt.
  void WriteGrey(const std::string& name, int salt, int width = 80, int height = 64) const {
    cv::Mat image(height, width, CV_8UC1);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) image.at<uint8_t>(y, x) = static_cast<uint8_t>(x + y + salt);
    }
    WriteImage(name, image);
  }
  // 80 x 64 depth whose pixel (x, y) is 257 x + y + salt: both bytes count.
  void WriteDepth(const std::string& name, int salt) const {
    cv::Mat image(64, 80, CV_16UC1);
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 80; ++x) {
        image.at<uint16_t>(y, x) = static_cast<uint16_t>(257 * x + y + salt);
      }
    }
    WriteImage(name, image);
  }
  void WriteImage(const std::string& name, const cv::Mat& image) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    ASSERT_TRUE(cv::imwrite((path_ / name).string(), image));
  }
  void Remove(const std::string& name) const { std::filesystem::remove_all(path_ / name); }

 private:
  std::filesystem::path path_;
};

// Folder of real recordings, or empty.
inline std::filesystem::path SharedData() {
  const char* const variable = std::getenv("GW_SHARED_DIR");
  const std::filesystem::path shared =
      variable != nullptr ? variable : std::filesystem::path(GW_SOURCE_DIR) / ".." / "shared";
  return std::filesystem::exists(shared / "data") ? shared / "data" : std::filesystem::path();
}

// What a bad folder must lead to.
inline void ExpectError(const Result<Recording>& result, ErrorCode code,
                        const std::vector<std::string>& parts) {
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, code) << result.error().message;
  for (const std::string& part : parts) {
    EXPECT_THAT(result.error().message, testing::HasSubstr(part));
  }
}

// Bad text for one file of a good folder, and what the refusal must say.
struct BadFile {
  const char* file;
  std::string text;
  std::vector<std::string> message;
};

// write(folder) makes the good folder, read(path) imports it. code: where all refusals have one.
template <typename Write, typename Read>
void ExpectRefused(const std::vector<BadFile>& cases, Write write, Read read,
                   std::optional<ErrorCode> code = std::nullopt) {
  for (const BadFile& c : cases) {
    const TestFolder folder;
    write(folder);
    folder.Write(c.file, c.text);
    SCOPED_TRACE(std::string(c.file) + ": " + c.text);
    const Result<Recording> recording = read(folder.path());
    ASSERT_FALSE(recording);
    ExpectError(recording, code.value_or(recording.error().code), c.message);
  }
}

inline void ExpectPose(const SE3& actual, const SE3& expected, double tolerance = 1e-9) {
  EXPECT_LT((expected.inverse() * actual).Log().norm(), tolerance);
}

inline std::string AllText(const std::vector<std::string>& lines) {
  std::string all;
  for (const std::string& line : lines) all += line + "\n";
  return all;
}

}  // namespace gw::importer

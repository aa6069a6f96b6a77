// The TUM importer on a small folder made here, and every way in which the folder can be wrong.
#include "tools/data/import/tum.h"

#include <gmock/gmock.h>

#include "tools/data/import/image_file.h"
#include "tools/data/import/test_folder.h"

namespace gw::importer {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Three images, of which the last has no depth; ground truth of the optical frame.
void WriteTum(const TestFolder& folder) {
  folder.Write("rgb.txt",
               "# t file\n10.000000 rgb/a.png\n10.033333 rgb/b.png\n10.066667 rgb/c.png\n");
  folder.Write("depth.txt", "# t file\n10.004000 depth/a.png\n10.030000 depth/b.png\n");
  folder.Write("groundtruth.txt",
               "# t\n9.9 0 0 0 0 0 0 1\n10.0 1 2 3 -0.5 0.5 -0.5 0.5\n10.1 1 2 3 0 0 0 1\n");
  for (const char* name : {"a", "b", "c"})
    folder.WriteGrey(std::string("rgb/") + name + ".png", *name);
  folder.WriteDepth("depth/a.png", 5);
  folder.WriteDepth("depth/b.png", 6);
}

TEST(Tum, PairsByTimeAndKeepsPixels) {
  const TestFolder folder;
  WriteTum(folder);
  const auto recording = ReadTum(folder.path(), {});
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->frames->size(), 2u);
  EXPECT_EQ(recording->frames->utime(1).us, 10033333);
  EXPECT_THAT(AllText(recording->warnings), HasSubstr("1 images have no depth image"));
  const auto pixels = recording->frames->Load(1);
  ASSERT_TRUE(pixels);
  EXPECT_EQ(pixels->left.format, PixelFormat::kGray8);
  EXPECT_EQ(pixels->left.bytes[80 * 3 + 7], 'b' + 10);
  EXPECT_EQ(pixels->depth.format, PixelFormat::kDepth16);
  const auto* depth = reinterpret_cast<const uint16_t*>(pixels->depth.bytes.data());
  EXPECT_EQ(depth[80 * 3 + 70], 257 * 70 + 3 + 6);
  EXPECT_TRUE(pixels->right.bytes.empty());
  const CameraCalibration& camera = recording->calibration.camera;
  EXPECT_EQ(camera.width, 80);
  EXPECT_EQ(camera.height, 64);
  EXPECT_EQ(camera.left.fx, 517.3);
  EXPECT_NEAR(camera.rate_hz, 30, 0.01);
  EXPECT_NEAR(camera.depth_unit_m, 0.0002, 1e-12);
}

// The second ground-truth pose has the optical frame turned as T_BC is: the body is level.
TEST(Tum, GroundTruthIsMovedFromTheOpticalFrameToTheBody) {
  const TestFolder folder;
  WriteTum(folder);
  const auto recording = ReadTum(folder.path(), {});
  ASSERT_TRUE(recording);
  ASSERT_EQ(recording->ground_truth.size(), 3u);
  ExpectPose(recording->ground_truth[1].T_GB, SE3(Eigen::Quaterniond::Identity(), {1, 2, 3}));
  for (const GroundTruth& truth : recording->ground_truth) {
    EXPECT_LT((truth.T_GB * recording->calibration.camera.T_BC).translation().norm(), 4);
  }
}

TEST(Tum, ColourBecomesGreyByTheStatedFormula) {
  const TestFolder folder;
  WriteTum(folder);
  folder.WriteImage("rgb/a.png", cv::Mat(64, 80, CV_8UC3, cv::Scalar(10, 20, 200)));  // b, g, r
  const auto recording = ReadTum(folder.path(), {});
  ASSERT_TRUE(recording);
  const auto pixels = recording->frames->Load(0);
  ASSERT_TRUE(pixels);
  EXPECT_EQ(pixels->left.bytes[0], std::lround(0.299 * 200 + 0.587 * 20 + 0.114 * 10));
  bool stated = false;
  for (const auto& [key, text] : recording->notes) {
    stated |= key == "images" && text.find(kGreyConversion) != std::string::npos;
  }
  EXPECT_TRUE(stated);
}

TEST(Tum, IntrinsicsOfTheCommandLineReplaceThePreset) {
  const TestFolder folder;
  WriteTum(folder);
  TumOptions options;
  options.intrinsics = *ParseIntrinsics("500,501,40,32");
  const auto recording = ReadTum(folder.path(), options);
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->calibration.camera.left.fy, 501);
  EXPECT_FALSE(recording->calibration.camera.left.distorted());
  EXPECT_EQ(ParseIntrinsics("1,2,3,4,5,6,7,8,9")->radtan[4], 9);
  for (const char* bad : {"", "1,2,3", "1,2,3,4,5", "a,2,3,4", "1,2,3,4,", "0,2,3,4", "1;2;3;4"}) {
    EXPECT_FALSE(ParseIntrinsics(bad)) << bad;
  }
}

TEST(Tum, MissingFilesAreNamedOrSkipped) {
  const TestFolder folder;
  WriteTum(folder);
  folder.Remove("depth/a.png");
  ExpectError(ReadTum(folder.path(), {}), ErrorCode::kNotFound,
              {"rgb.txt:2: ", "depth/a.png", "--skip-missing"});
  TumOptions options;
  options.skip_missing = true;
  const auto recording = ReadTum(folder.path(), options);
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->frames->size(), 1u);
  EXPECT_EQ(recording->skipped_frames, 1);
  folder.Remove("depth/b.png");
  ExpectError(ReadTum(folder.path(), options), ErrorCode::kNotFound, {"no complete frame"});
}

TEST(Tum, BadFoldersAreRefusedWithFileAndLine) {
  const std::vector<BadFile> cases = {
      {"rgb.txt", "", {"rgb.txt: holds no record"}},
      {"rgb.txt", "10.0\n", {"rgb.txt:1: the file name is missing"}},
      {"rgb.txt", "#\nx rgb/a.png\n", {"rgb.txt:2: 'x'"}},
      {"depth.txt", "20.0 depth/a.png\n", {"within 20 ms"}},
      {"groundtruth.txt", "1 2 3\n", {"groundtruth.txt:1: ", "fields"}},
      {"groundtruth.txt", "1 2 3 4 0 0 0 0\n", {"groundtruth.txt:1: ", "norm"}},
      {"groundtruth.txt", "1 2 3 4 0 0 0 inf\n", {"groundtruth.txt:1: "}},
  };
  ExpectRefused(
      cases, WriteTum, [](const auto& path) { return ReadTum(path, {}); }, ErrorCode::kBadData);
  const TestFolder folder;
  ExpectError(ReadTum(folder.path(), {}), ErrorCode::kNotFound, {"rgb.txt: not there"});
  WriteTum(folder);
  TumOptions options;
  options.camera = "fr4";
  ExpectError(ReadTum(folder.path(), options), ErrorCode::kInvalidArgument, {"fr4"});
}

TEST(Tum, BadImagesAreRefusedWhenTheyAreRead) {
  const TestFolder folder;
  WriteTum(folder);
  const auto recording = ReadTum(folder.path(), {});
  ASSERT_TRUE(recording);
  const auto error_of_frame = [&] {
    const auto pixels = recording->frames->Load(1);
    return pixels ? std::string("no error") : pixels.error().message;
  };
  folder.WriteGrey("rgb/b.png", 0, 64, 64);
  EXPECT_THAT(error_of_frame(), AllOf(HasSubstr("b.png"), HasSubstr("is 64 x 64")));
  folder.WriteDepth("rgb/b.png", 0);
  EXPECT_THAT(error_of_frame(), HasSubstr("16-bit, 1 channels"));
  folder.Write("rgb/b.png", "no image");
  EXPECT_THAT(error_of_frame(), HasSubstr("cannot be decoded"));
  folder.WriteGrey("rgb/b.png", 0);
  folder.WriteGrey("depth/b.png", 0);
  EXPECT_THAT(error_of_frame(), HasSubstr("16-bit depth"));
  folder.WriteDepth("depth/b.png", 0);
  EXPECT_EQ(error_of_frame(), "no error");
  std::filesystem::resize_file(folder.path() / "rgb/b.png", 200);
  EXPECT_THAT(error_of_frame(), HasSubstr("cannot be decoded"));
  folder.Remove("rgb/b.png");
  EXPECT_THAT(error_of_frame(), HasSubstr("not there"));
}

}  // namespace
}  // namespace gw::importer

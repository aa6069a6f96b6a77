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

// The images of the folder are no Kinect's.
TumOptions Own() {
  TumOptions options;
  options.intrinsics = *ParseIntrinsics("60,61,40,32");
  return options;
}

// A folder inside another whose images have the size of the presets.
void WriteKinect(const TestFolder& folder, const std::string& name) {
  folder.Write(name + "/rgb.txt", "10.0 rgb/a.png\n");
  folder.Write(name + "/depth.txt", "10.0 depth/a.png\n");
  folder.WriteGrey(name + "/rgb/a.png", 1, 640, 480);
  folder.WriteImage(name + "/depth/a.png", cv::Mat(480, 640, CV_16UC1, cv::Scalar(5000)));
}

TEST(Tum, PairsByTimeAndKeepsPixels) {
  const TestFolder folder;
  WriteTum(folder);
  const auto recording = ReadTum(folder.path(), Own());
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
  EXPECT_EQ(camera.left.fy, 61);
  EXPECT_EQ(camera.readout_s, 0);  // the Kinect's rolling shutter goes with its preset
  EXPECT_NEAR(camera.rate_hz, 30, 0.01);
  EXPECT_NEAR(camera.depth_unit_m, 0.0002, 1e-12);
}

// The second ground-truth pose has the optical frame turned as T_BC is: the body is level.
TEST(Tum, GroundTruthIsMovedFromTheOpticalFrameToTheBody) {
  const TestFolder folder;
  WriteTum(folder);
  const auto recording = ReadTum(folder.path(), Own());
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
  const auto recording = ReadTum(folder.path(), Own());
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
  for (const char* bad : {"", "1,2,3", "1,2,3,4,5", "a,2,3,4", "1,2,3,4,", "0,2,3,4", "-1,2,3,4",
                          "1,0,3,4", "1;2;3;4"}) {
    EXPECT_FALSE(ParseIntrinsics(bad)) << bad;
  }
}

TEST(Tum, TheFolderNamesTheCamera) {
  const TestFolder folder;
  const auto fx = [&](const std::string& name, const TumOptions& options = {}) {
    WriteKinect(folder, name);
    const auto recording = ReadTum(folder.path() / name, options);
    EXPECT_TRUE(recording) << recording.error().message;
    const bool assumed =
        AllText(recording->warnings).find("freiburg1's Kinect are ASSUMED") != std::string::npos;
    EXPECT_EQ(assumed, name == "office") << name;
    return recording->calibration.camera.left.fx;
  };
  EXPECT_EQ(fx("rgbd_dataset_freiburg1_rpy"), 517.3);
  EXPECT_EQ(fx("rgbd_dataset_freiburg2_desk"), 520.9);
  EXPECT_EQ(fx("TUM_FR3_office"), 535.4);
  EXPECT_EQ(fx("office"), 517.3);
  TumOptions options;
  options.camera = "fr2";
  EXPECT_EQ(fx("rgbd_dataset_freiburg1_xyz", options), 520.9);
}

TEST(Tum, PresetsAreOfOneImageShape) {
  const TestFolder folder;
  WriteTum(folder);
  ExpectError(ReadTum(folder.path(), {}), ErrorCode::kBadData,
              {"640 x 480", "80 x 64", "--intrinsics"});
}

TEST(Tum, TheDepthUnitIsStatedOrSaid) {
  const TestFolder folder;
  WriteTum(folder);
  const auto assumed = ReadTum(folder.path(), Own());
  ASSERT_TRUE(assumed);
  EXPECT_THAT(AllText(assumed->warnings),
              AllOf(HasSubstr("ASSUMED in TUM's unit"), HasSubstr("--depth-unit 0.001")));
  TumOptions options = Own();
  options.depth_unit_m = 0.001;
  const auto stated = ReadTum(folder.path(), options);
  ASSERT_TRUE(stated);
  EXPECT_EQ(stated->calibration.camera.depth_unit_m, 0.001);
  EXPECT_THAT(AllText(stated->warnings), testing::Not(HasSubstr("ASSUMED")));
}

// Good images are worth a log, whatever the ground truth is like.
TEST(Tum, GroundTruthWithoutAttitudeIsLeftOut) {
  for (const char* text : {"9 1 2 3 0 0 0 0\n10 1 2 3 0 0 0 0\n", "9 1 2 3 0 0 0 nan\n"}) {
    const TestFolder folder;
    WriteTum(folder);
    folder.Write("groundtruth.txt", text);
    const auto recording = ReadTum(folder.path(), Own());
    ASSERT_TRUE(recording) << recording.error().message;
    EXPECT_TRUE(recording->ground_truth.empty());
    EXPECT_THAT(AllText(recording->warnings),
                AllOf(HasSubstr("groundtruth.txt:1: "), HasSubstr("no ground truth in the log")));
  }
}

TEST(Tum, SpoiltRowsOfGroundTruthAreCountedAndNamed) {
  const TestFolder folder;
  WriteTum(folder);
  folder.Write("groundtruth.txt",
               "9 0 0 0 0 0 0 1\n10 0 0 0 4.8 0 0 1\n11 nan nan nan nan nan nan nan\n"
               "12 0 0 0 0 0 0 1\n13 0 0 0 0 0 0.2 1\n");
  const auto recording = ReadTum(folder.path(), Own());
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->ground_truth.size(), 3u);
  EXPECT_THAT(AllText(recording->warnings),
              AllOf(HasSubstr("groundtruth.txt:2: the quaternion has norm"),
                    HasSubstr("2 of 5 rows"), HasSubstr("1 of 5 quaternions are rounded")));
}

// Byte-order mark, CRLF, back-slashes, quoted and plain names with blanks, no newline at the end.
TEST(Tum, ListsFromWindowsAreRead) {
  const TestFolder folder;
  WriteTum(folder);
  folder.WriteGrey("rgb/left cam.png", 'b');
  folder.Write("rgb.txt",
               "\xEF\xBB\xBF"
               "10.000000 rgb\\a.png\r\n10.033333 rgb/left cam.png\r\n"
               "10.066667,\"rgb/left cam.png\"");
  folder.Write("depth.txt", "10.004 depth/a.png\r\n10.030 depth/b.png\r\n10.066 depth\\b.png\r\n");
  folder.Write("groundtruth.txt",
               "\xEF\xBB\xBF"
               "9.9 0 0 0 0 0 0 1\r\n10 0 0 0 0 0 0 1\r\n");
  const auto recording = ReadTum(folder.path(), Own());
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->frames->size(), 3u);
  for (size_t i = 0; i < 3; ++i) EXPECT_TRUE(recording->frames->Load(i));
  EXPECT_EQ(recording->ground_truth.size(), 2u);
}

// Commas and several blanks in a name, a column more, a comma at the end.
TEST(Tum, NamesOfAnyKindAreFound) {
  const TestFolder folder;
  WriteTum(folder);
  folder.WriteGrey("rgb/left,  1.png", 'a');
  folder.Write("rgb.txt",
               "timestamp,filename\n10.000000,rgb/left,  1.png\n10.033333,rgb/b.png,\n"
               "10.066667,rgb/c.png,exposure 3\n");
  folder.Write("depth.txt", "10.004 depth/a.png\n10.030 depth/b.png\n10.066 depth/b.png\n");
  const auto recording = ReadTum(folder.path(), Own());
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->frames->size(), 3u);
  for (size_t i = 0; i < 3; ++i) EXPECT_TRUE(recording->frames->Load(i)) << i;
}

TEST(Tum, AssociationsServeWhereThereAreNoLists) {
  for (const bool depth_first : {false, true}) {
    const TestFolder folder;
    WriteTum(folder);
    folder.Remove("rgb.txt");
    folder.Remove("depth.txt");
    folder.Write("associations.txt", depth_first ? "10 depth/a.png 10 rgb/a.png\n"
                                                   "11 depth\\b.png 11 rgb\\b.png\n"
                                                 : "10 rgb/a.png 10 depth/a.png\n"
                                                   "11 rgb\\b.png 11 depth\\b.png\n");
    const auto recording = ReadTum(folder.path(), Own());
    ASSERT_TRUE(recording) << recording.error().message;
    ASSERT_EQ(recording->frames->size(), 2u);
    const auto pixels = recording->frames->Load(1);
    ASSERT_TRUE(pixels) << pixels.error().message;
    EXPECT_EQ(pixels->left.format, PixelFormat::kGray8);
    EXPECT_EQ(pixels->depth.format, PixelFormat::kDepth16);
  }
}

// A camera that looks along z with y up, moving up by 1 m and turning about its x axis.
TEST(Tum, ANegativeFyIsACameraWithYUp) {
  const TestFolder folder;
  WriteTum(folder);
  folder.Write("groundtruth.txt", "9.9 0 0 0 0 0 0 1\n10 1 2 3 0.6 0 0 0.8\n");
  TumOptions options = Own();
  options.intrinsics = *ParseIntrinsics("60,-61,40,32");
  const auto recording = ReadTum(folder.path(), options);
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->calibration.camera.left.fy, 61);
  EXPECT_THAT(AllText(recording->warnings), HasSubstr("fy is negative"));
  const SE3& T_BC = recording->calibration.camera.T_BC;
  const SE3 T_GC = recording->ground_truth[1].T_GB * T_BC;
  // A point in front is at the same pixel whichever way it is computed.
  const SE3 given(Eigen::Quaterniond(0.8, 0.6, 0, 0), {1, 2, 3});
  const Eigen::Vector3d point(2, 3, 9);
  const Eigen::Vector3d seen = given.inverse() * point;
  const Eigen::Vector3d mirrored = T_GC.inverse() * Eigen::Vector3d(2, -3, 9);
  EXPECT_LT((Eigen::Vector3d(seen.x(), -seen.y(), seen.z()) - mirrored).norm(), 1e-9);
}

TEST(Tum, AllFaultsOfAFolderAreNamedTogether) {
  const TestFolder folder;
  WriteTum(folder);
  folder.Write("rgb.txt", "10 rgb/a.png\nx rgb/b.png\n10.1\n");
  folder.Write("depth.txt", "y depth/a.png\n");
  folder.Write("groundtruth.txt", "1 2 3\n");
  ExpectError(
      ReadTum(folder.path(), Own()), ErrorCode::kBadData,
      {"rgb.txt:2: 'x'", "rgb.txt:3: the file name", "depth.txt:1: 'y'", "groundtruth.txt:1: "});
}

TEST(Tum, AllFilesThatAreMissingOrBrokenAreNamedTogether) {
  const TestFolder folder;
  WriteTum(folder);
  folder.Remove("depth/a.png");
  folder.Write("rgb/b.png", "no image");
  ExpectError(ReadTum(folder.path(), Own()), ErrorCode::kNotFound,
              {"rgb.txt:2: ", "depth/a.png is not there", "rgb/b.png: cannot be decoded",
               "--skip-missing"});
}

TEST(Tum, TimesThatCountImagesAreSuspected) {
  const TestFolder folder;
  WriteTum(folder);
  std::string list;
  for (int i = 0; i < 12; ++i) list += std::to_string(i) + " rgb/a.png\n";
  folder.Write("rgb.txt", list);
  for (size_t at = list.find("rgb"); at != std::string::npos; at = list.find("rgb")) {
    list.replace(at, 3, "depth");
  }
  folder.Write("depth.txt", list);
  const auto recording = ReadTum(folder.path(), Own());
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_THAT(AllText(recording->warnings), HasSubstr("every time is a whole second"));
}

TEST(Tum, MissingFilesAreNamedOrSkipped) {
  const TestFolder folder;
  WriteTum(folder);
  folder.Remove("depth/a.png");
  ExpectError(ReadTum(folder.path(), Own()), ErrorCode::kNotFound,
              {"rgb.txt:2: ", "depth/a.png", "--skip-missing"});
  TumOptions options = Own();
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
      {"rgb.txt",
       "1e9 rgb/a.png\n1e9 rgb/b.png\n1e9 rgb/c.png\n",
       {"rgb.txt: 2 of 3 records repeat a time", "digits"}},
  };
  ExpectRefused(
      cases, WriteTum, [](const auto& path) { return ReadTum(path, Own()); }, ErrorCode::kBadData);
  const TestFolder folder;
  ExpectError(ReadTum(folder.path(), Own()), ErrorCode::kNotFound, {"rgb.txt: not there"});
  WriteTum(folder);
  TumOptions options;
  options.camera = "fr4";
  ExpectError(ReadTum(folder.path(), options), ErrorCode::kInvalidArgument, {"fr4"});
}

TEST(Tum, BadImagesAreRefusedWhenTheyAreRead) {
  const TestFolder folder;
  WriteTum(folder);
  const auto recording = ReadTum(folder.path(), Own());
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

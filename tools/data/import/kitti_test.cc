// The KITTI importer on a small folder made here, and every way in which the folder can be wrong.
#include "tools/data/import/kitti.h"

#include <gtest/gtest.h>

#include "tools/data/import/test_folder.h"

namespace gw::importer {
namespace {

void WriteKitti(const TestFolder& folder) {
  folder.Write("calib.txt",
               "P0: 700 0 40 0 0 700 32 0 0 0 1 0\nP1: 700 0 40 -350 0 700 32 0 0 0 1 0\n"
               "P2: 700 0 40 0 0 700 32 0 0 0 1 0\n");
  folder.Write("times.txt", "0.000000e+00\n1.037980e-01\n");
  folder.Write("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 2\n");
  for (const char* name :
       {"image_0/000000.png", "image_1/000000.png", "image_0/000001.png", "image_1/000001.png"}) {
    folder.WriteGrey(name, name[6]);
  }
}

TEST(Kitti, ReadsRectifiedStereo) {
  const TestFolder folder;
  WriteKitti(folder);
  const auto recording = ReadKitti(folder.path(), {});
  ASSERT_TRUE(recording) << recording.error().message;
  const CameraCalibration& camera = recording->calibration.camera;
  EXPECT_EQ(camera.kind, CameraKind::kStereo);
  EXPECT_NEAR(camera.T_C0C1.translation().x(), 0.5, 1e-12);
  EXPECT_NEAR(camera.depth_max_m, 70, 1e-9);  // 700 px * 0.5 m / 5 px
  EXPECT_LT(camera.depth_min_m, camera.depth_max_m);
  EXPECT_EQ(recording->frames->utime(1).us, 103798);
  const auto pixels = recording->frames->Load(1);
  ASSERT_TRUE(pixels);
  EXPECT_EQ(pixels->left.bytes[0], '0');
  EXPECT_EQ(pixels->right.bytes[0], '1');
}

// 1 m to the right and 2 m ahead of the camera is 2 m ahead and 1 m to the right of the body.
TEST(Kitti, GroundTruthIsInTheFirstBodyFrame) {
  const TestFolder folder;
  WriteKitti(folder);
  const auto recording = ReadKitti(folder.path(), {});
  ASSERT_TRUE(recording);
  ASSERT_EQ(recording->ground_truth.size(), 2u);
  ExpectPose(recording->ground_truth[0].T_GB, SE3());
  ExpectPose(recording->ground_truth[1].T_GB, SE3(Eigen::Quaterniond::Identity(), {2, -1, 0}));
}

TEST(Kitti, BadFoldersAreRefusedWithFileAndLine) {
  const std::vector<BadFile> cases = {
      {"calib.txt", "P0: 700 0 40 0 0 700 32 0 0 0 1 0\n", {"calib.txt: P0 or P1 is missing"}},
      {"calib.txt", "P0: 700 0 40\n", {"calib.txt:1: "}},
      {"calib.txt", "P0: 0 0 40 0 0 700 32 0 0 0 1 0\n", {"calib.txt:1: ", "focal"}},
      {"calib.txt",
       "P0: 700 0 40 0 0 700 32 0 0 0 1 0\nP1: 700 0 40 350 0 700 32 0 0 0 1 0\n",
       {"swapped"}},
      {"times.txt", "0\n0\n", {"times.txt:2: ", "does not increase"}},
      {"times.txt", "0\n1\n2\n", {"times.txt:3: ", "000002.png"}},
      {"poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n", {"poses.txt: holds 1 poses"}},
      {"poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n2 0 0 1 0 1 0 0 0 0 1 2\n", {"poses.txt:2: "}},
  };
  ExpectRefused(cases, WriteKitti, [](const auto& path) { return ReadKitti(path, {}); });
}

}  // namespace
}  // namespace gw::importer

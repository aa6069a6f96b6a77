// Cameras that are known, from images of boards that are rendered through them.
#include "tools/lab/calibrate/camera_calibration.h"

#include <gmock/gmock.h>

#include <cstdio>

#include "tools/lab/calibrate/test_board.h"

namespace gw::calibrate {
namespace {

using testing::HasSubstr;

constexpr int kWidth = 480, kHeight = 360;
constexpr int kViews = 16;
const TestLens kPinhole{LensModel::kRadtan,
                        {330, 328, 242, 177, -0.28, 0.09, 0.0008, -0.0005, -0.015}};
const TestLens kPinholeRight{LensModel::kRadtan,
                             {327, 329, 236, 181, -0.27, 0.08, -0.0006, 0.0004, -0.01}};
const TestLens kFisheye{LensModel::kEquidistant,
                        {190, 191, 241, 178, -0.012, 0.011, -0.004, 0.0005, 0}};
const TestLens kFisheyeRight{LensModel::kEquidistant,
                             {192, 190, 238, 182, -0.010, 0.009, -0.003, 0.0004, 0}};

std::vector<BoardView> SeeBoards(const Board& board, const PrintStyle& style,
                                 const std::vector<SE3>& poses, const TestLens& left,
                                 const TestLens* right, const SE3& T_C1C0) {
  const BoardPaint paint(board, style);
  const BoardCamera left_camera(left, kWidth, kHeight);
  std::optional<BoardCamera> right_camera;
  if (right != nullptr) right_camera.emplace(*right, kWidth, kHeight);
  BoardFinder finder(board);
  std::vector<BoardView> views;
  for (size_t i = 0; i < poses.size(); ++i) {
    BoardView view{std::to_string(i), finder.Find(left_camera.Look(paint, poses[i], i)), {}};
    if (right_camera) {
      view.right = finder.Find(right_camera->Look(paint, T_C1C0 * poses[i], 1000 + i));
    }
    views.push_back(std::move(view));
  }
  return views;
}

void ExpectLens(const char* name, LensModel model, const LensEstimate& found,
                const TestLens& truth) {
  EXPECT_LE(found.rms_px, 0.1) << name;
  const auto names = LensParameterNames(model);
  for (int i = 0; i < NumLensParameters(model); ++i) {
    const auto k = static_cast<size_t>(i);
    std::printf("%s %s %.5f +- %.5f, truth %.5f\n", name, names[k], found.values[k],
                found.sigmas[k], truth.values[k]);
    EXPECT_NEAR(found.values[k], truth.values[k], 3 * found.sigmas[k]) << name << " " << names[k];
    EXPECT_GT(found.sigmas[k], 0) << name << " " << names[k];
  }
  EXPECT_LT(found.sigmas[0], 0.003 * found.values[0]) << name;
}

TEST(CameraCalibration, RadtanFromACheckerboard) {
  const Board board = ParseBoard("checkerboard:9x6:0.06").value();
  const auto views =
      SeeBoards(board, {}, PosesAround(board, 0.7, 0.25, kViews, 3), kPinhole, nullptr, SE3());
  const auto found = CalibrateCamera(board, LensModel::kRadtan, kWidth, kHeight, views);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_GE(found->views, 10);
  ExpectLens("checkerboard", LensModel::kRadtan, found->left, kPinhole);
  EXPECT_FALSE(found->right);
}

TEST(CameraCalibration, RadtanStereoFromAprilTags) {
  const Board board = ParseBoard("apriltag:6x6:0.07:0.3").value();
  const SE3 T_C0C1(ExpSO3({0.004, -0.01, 0.006}), {0.11, 0.001, -0.002});
  const auto views = SeeBoards(board, {}, PosesAround(board, 0.75, 0.2, kViews, 5), kPinhole,
                               &kPinholeRight, T_C0C1.inverse());
  const auto found = CalibrateCamera(board, LensModel::kRadtan, kWidth, kHeight, views);
  ASSERT_TRUE(found) << found.error().message;
  ExpectLens("left", LensModel::kRadtan, found->left, kPinhole);
  ASSERT_TRUE(found->right);
  ExpectLens("right", LensModel::kRadtan, *found->right, kPinholeRight);
  const Vector6d error = (T_C0C1.inverse() * found->T_C0C1).Log();
  for (int i = 0; i < 6; ++i) {
    EXPECT_LT(std::abs(error[i]), 3 * found->sigmas_C0C1[i]) << i;
    EXPECT_LT(found->sigmas_C0C1[i], 1e-3) << i;
  }
}

TEST(CameraCalibration, FisheyeFromAprilTags) {
  const Board board = ParseBoard("apriltag:6x6:0.07:0.3").value();
  const auto views = SeeBoards(board, {2, true}, PosesAround(board, 0.4, 0.3, kViews, 6), kFisheye,
                               nullptr, SE3());
  const auto found = CalibrateCamera(board, LensModel::kEquidistant, kWidth, kHeight, views);
  ASSERT_TRUE(found) << found.error().message;
  ExpectLens("fisheye", LensModel::kEquidistant, found->left, kFisheye);
}

TEST(CameraCalibration, FisheyeStereoFromACheckerboard) {
  const Board board = ParseBoard("checkerboard:9x6:0.05").value();
  const SE3 T_C0C1(ExpSO3({-0.003, 0.008, 0.002}), {0.06, 0, 0.001});
  const auto views = SeeBoards(board, {}, PosesAround(board, 0.4, 0.25, kViews, 8), kFisheye,
                               &kFisheyeRight, T_C0C1.inverse());
  const auto found = CalibrateCamera(board, LensModel::kEquidistant, kWidth, kHeight, views);
  ASSERT_TRUE(found) << found.error().message;
  ExpectLens("left", LensModel::kEquidistant, found->left, kFisheye);
  ASSERT_TRUE(found->right);
  ExpectLens("right", LensModel::kEquidistant, *found->right, kFisheyeRight);
  const Vector6d error = (T_C0C1.inverse() * found->T_C0C1).Log();
  for (int i = 0; i < 6; ++i) EXPECT_LT(std::abs(error[i]), 3 * found->sigmas_C0C1[i]) << i;
}

// Corners as a lens projects them, with noise of a twentieth of a pixel.
std::vector<BoardView> ProjectBoards(const Board& board, const std::vector<SE3>& poses) {
  CounterRng rng(1, 1, 1);
  std::vector<BoardView> views;
  for (const SE3& T_CBoard : poses) {
    BoardView view{std::to_string(views.size()), {}, {}};
    for (int i = 0; i < board.num_corners(); ++i) {
      const Eigen::Vector2d on_board = board.CornerAt(i);
      const Eigen::Vector3d p = T_CBoard * Eigen::Vector3d(on_board.x(), on_board.y(), 0);
      Eigen::Vector2d pixel;
      if (!ProjectThroughLens(kPinhole.model, kPinhole.values.data(), p.data(), pixel.data()))
        continue;
      if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > kWidth || pixel.y() > kHeight) continue;
      view.left.push_back({i, pixel + 0.05 * Eigen::Vector2d(rng.Normal(), rng.Normal())});
    }
    if (std::ssize(view.left) >= BoardFinder::kFewestCorners) views.push_back(std::move(view));
  }
  return views;
}

TEST(CameraCalibration, AViewThatDoesNotFitIsLeftOutAndNamed) {
  const Board board = ParseBoard("checkerboard:9x6:0.06").value();
  auto views = ProjectBoards(board, PosesAround(board, 0.7, 0.2, 12, 3));
  views[4].name = "moved.png";
  for (BoardCorner& corner : views[4].left) {
    if (corner.index % 9 > 4) corner.pixel.x() += 3;
  }
  const auto found = CalibrateCamera(board, LensModel::kRadtan, kWidth, kHeight, views);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_THAT(found->left_out, testing::ElementsAre("moved.png"));
  EXPECT_LT(found->left.rms_px, 0.1);
  EXPECT_NEAR(found->left.values[0], kPinhole.values[0], 3 * found->left.sigmas[0]);
}

// Boards that are all parallel to the image do not tell the focal length.
TEST(CameraCalibration, WhatTheViewsDoNotTellIsSaid) {
  const Board board = ParseBoard("checkerboard:9x6:0.06").value();
  std::vector<SE3> flat;
  flat.reserve(10);
  for (int i = 0; i < 10; ++i) {
    flat.push_back(SE3(Eigen::Quaterniond(0, 1, 0, 0), {-0.25 + 0.01 * i, 0.15, 0.8}));
  }
  const auto found =
      CalibrateCamera(board, LensModel::kRadtan, kWidth, kHeight, ProjectBoards(board, flat));
  if (found) {
    const auto wanting = JudgeCamera(*found);
    EXPECT_THAT(wanting, testing::Contains(HasSubstr("focal length is known to")));
  } else {
    EXPECT_THAT(found.error().message, HasSubstr("tilt the board"));
  }
  const auto few = CalibrateCamera(board, LensModel::kRadtan, kWidth, kHeight,
                                   ProjectBoards(board, PosesAround(board, 0.7, 0.1, 3, 1)));
  ASSERT_FALSE(few);
  EXPECT_THAT(few.error().message, HasSubstr("usable in 3 images, at least 5"));
}

}  // namespace
}  // namespace gw::calibrate

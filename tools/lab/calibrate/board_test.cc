#include "tools/lab/calibrate/board.h"

#include <gmock/gmock.h>

#include "tools/lab/calibrate/test_board.h"

namespace gw::calibrate {
namespace {

const TestLens kLens{LensModel::kRadtan, {420, 418, 318, 242, -0.05, 0.02, 0.001, -0.0005, 0}};

// Where the corners of a board are seen, exactly.
Eigen::Vector2d Exactly(const Board& board, const SE3& T_CBoard, int index) {
  const Eigen::Vector2d on_board = board.CornerAt(index);
  const Eigen::Vector3d p = T_CBoard * Eigen::Vector3d(on_board.x(), on_board.y(), 0);
  Eigen::Vector2d pixel;
  ProjectThroughLens(kLens.model, kLens.values.data(), p.data(), pixel.data());
  return pixel;
}

TEST(Board, TextIsParsedOrRefused) {
  const auto tags = ParseBoard("apriltag:6x5:0.088:0.3");
  ASSERT_TRUE(tags) << tags.error().message;
  EXPECT_EQ(tags->columns, 6);
  EXPECT_EQ(tags->rows, 5);
  EXPECT_EQ(tags->num_corners(), 120);
  EXPECT_NEAR(tags->CornerAt(4 * 7 + 2).x(), 0.088 * 1.3 + 0.088, 1e-12);
  EXPECT_NEAR(tags->CornerAt(4 * 7 + 2).y(), 0.088 * 1.3 + 0.088, 1e-12);
  const auto squares = ParseBoard("checkerboard:8x5:0.03");
  ASSERT_TRUE(squares);
  EXPECT_NEAR(squares->CornerAt(9).y(), 0.03, 1e-12);
  for (const char* bad :
       {"", "apriltag", "apriltag:6x6:0.088", "apriltag:6:0.088:0.3", "checkerboard:2x5:0.03",
        "checkerboard:8x5:30", "circles:8x5:0.03", "apriltag:6x6:0.088:0.3x", "apriltag:0x6:0.1:1",
        "apriltag:6x6:nan:0.3", "apriltag:600x6:0.1:0.3"}) {
    EXPECT_FALSE(ParseBoard(bad)) << bad;
  }
}

TEST(Board, CornersAreFoundToATenthOfAPixel) {
  const BoardCamera camera(kLens, 640, 480);
  struct Case {
    const char* board;
    PrintStyle style;
  };
  for (const Case& c :
       {Case{"apriltag:6x6:0.088:0.3", {1, false}}, Case{"apriltag:6x6:0.088:0.3", {2, true}},
        Case{"checkerboard:8x5:0.08", {}}}) {
    const Board board = ParseBoard(c.board).value();
    const BoardPaint paint(board, c.style);
    BoardFinder finder(board);
    const auto poses = PosesAround(board, 1.0, 0.1, 3, 4);
    for (size_t i = 0; i < poses.size(); ++i) {
      const auto found = finder.Find(camera.Look(paint, poses[i], i));
      EXPECT_GE(std::ssize(found), board.num_corners() * 3 / 4) << c.board << " view " << i;
      double sum = 0;
      for (const BoardCorner& corner : found) {
        sum += (corner.pixel - Exactly(board, poses[i], corner.index)).squaredNorm();
      }
      EXPECT_LT(std::sqrt(sum / static_cast<double>(found.size())), 0.1)
          << c.board << " border " << c.style.border_bits << " view " << i;
    }
  }
}

TEST(Board, WhatIsNoBoardIsNotFound) {
  const Board board = ParseBoard("apriltag:6x6:0.088:0.3").value();
  BoardFinder tags(board);
  BoardFinder squares(ParseBoard("checkerboard:8x5:0.08").value());
  const cv::Mat blank(480, 640, CV_8U, cv::Scalar(120));
  EXPECT_TRUE(tags.Find(blank).empty());
  EXPECT_TRUE(squares.Find(blank).empty());
  // Tags of another layout make no flat board of this one.
  const BoardCamera camera(kLens, 640, 480);
  const Board other = ParseBoard("apriltag:5x5:0.088:0.3").value();
  const BoardPaint paint(other, {});
  EXPECT_TRUE(tags.Find(camera.Look(paint, PosesAround(other, 1.0, 0, 1, 1)[0], 1)).empty());
}

}  // namespace
}  // namespace gw::calibrate

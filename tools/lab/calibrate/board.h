// Calibration boards, and finding them in images.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/core/result.h"

namespace gw::calibrate {

// A flat board whose frame has x to its right, y up and z towards the reader; corners have z 0.
struct Board {
  enum class Kind { kAprilTags, kCheckerboard };
  Kind kind = Kind::kAprilTags;
  int columns = 0, rows = 0;  // tags, or inner corners of the squares
  double size_m = 0;          // side of a tag (its black square), or of a square
  double gap = 0;             // between tags, as a share of their side

  int num_corners() const { return columns * rows * (kind == Kind::kAprilTags ? 4 : 1); }
  // m. Of a tag: lower left, lower right, upper right, upper left; tag 0 is at the lower left, the
  // next ones follow to the right, then upwards (Kalibr's grid). Inner corners of squares run to
  // the right, then upwards. Precondition: 0 <= index < num_corners().
  Eigen::Vector2d CornerAt(int index) const;
};

// "apriltag:6x6:0.088:0.3" (tags of family 36h11 across and up, side in m, gap as a share of it) or
// "checkerboard:8x5:0.03" (inner corners across and up, side of a square in m). Error:
// kInvalidArgument.
Result<Board> ParseBoard(const std::string& text);

struct BoardCorner {
  int index = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

// Finds a board in grey images, to a small part of a pixel.
class BoardFinder {
 public:
  explicit BoardFinder(const Board& board);

  // What is seen of the board; empty when it is not seen well enough to be used: fewer than
  // kFewestCorners, or corners that are no flat board. Tags may be printed turned by quarters, and
  // their rows numbered downwards: what makes a flat board is taken.
  std::vector<BoardCorner> Find(const cv::Mat& grey);

  static constexpr int kFewestCorners = 12;

 private:
  std::vector<BoardCorner> FindTags(const cv::Mat& grey);
  std::vector<BoardCorner> FindSquares(const cv::Mat& grey) const;

  Board board_;
  int border_bits_ = 0;  // of the tags, once it is known
};

}  // namespace gw::calibrate

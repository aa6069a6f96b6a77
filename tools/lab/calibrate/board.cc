#include "tools/lab/calibrate/board.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "tools/lab/calibrate/tag_corners.h"

namespace gw::calibrate {
namespace {

constexpr int kLargestSide = 50;  // tags or corners
// Corners of a flat board seen through a lens are off a homography by the lens alone; those of a
// wrong order by parts of a tag. As a share of the board's size in the image.
constexpr double kLargestMisfit = 0.05;

struct SeenTag {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;  // clockwise, in the order of the detector
};

// Kalibr prints squares that touch the tags' corners and make one black net of them all: pixels
// count as black that are darker than their surroundings by this, of 255. A low value finds tags in
// dim images, a high one cuts the net where blur has made it grey.
constexpr std::array kDarker = {20, 7};
// Images below this width are enlarged, so that the thin parts of small tags have some pixels.
constexpr int kWideEnough = 1000;

std::vector<SeenTag> DetectTags(const cv::Mat& grey, int border_bits, int darker) {
  const cv::Ptr<cv::aruco::Dictionary> family =
      cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11);
  const cv::Ptr<cv::aruco::DetectorParameters> parameters = cv::aruco::DetectorParameters::create();
  parameters->markerBorderBits = border_bits;
  parameters->adaptiveThreshConstant = darker;
  parameters->adaptiveThreshWinSizeMax = 43;
  std::vector<int> ids;
  std::vector<std::vector<cv::Point2f>> corners;
  cv::aruco::detectMarkers(grey, family, corners, ids, parameters);
  std::map<int, int> seen;
  for (const int id : ids) ++seen[id];
  std::vector<SeenTag> tags;
  for (size_t i = 0; i < ids.size(); ++i) {
    if (seen[ids[i]] > 1) continue;  // a reflection, or two boards
    SeenTag tag{ids[i], {}};
    for (size_t k = 0; k < 4; ++k) tag.corners[k] = {corners[i][k].x, corners[i][k].y};
    tags.push_back(tag);
  }
  std::sort(tags.begin(), tags.end(),
            [](const SeenTag& a, const SeenTag& b) { return a.id < b.id; });
  return tags;
}

// Tags whose sides are not to be seen well are left out.
std::vector<SeenTag> WithSharpCorners(const cv::Mat& grey, const std::vector<SeenTag>& tags) {
  std::vector<SeenTag> sharp;
  for (const SeenTag& tag : tags) {
    const auto corners = CornersOfSquare(grey, tag.corners);
    if (corners) sharp.push_back({tag.id, *corners});
  }
  return sharp;
}

// How tags may be printed: turned by quarters, and with rows numbered upwards or downwards.
struct Order {
  int quarter = 0;
  bool downwards = false;
};

std::vector<BoardCorner> InOrder(const Board& board, const std::vector<SeenTag>& tags,
                                 const Order& order) {
  std::vector<BoardCorner> out;
  for (const SeenTag& tag : tags) {
    if (tag.id >= board.columns * board.rows) continue;
    const int row = tag.id / board.columns;
    const int column = tag.id % board.columns;
    const int place = (order.downwards ? board.rows - 1 - row : row) * board.columns + column;
    for (int k = 0; k < 4; ++k) {
      // Ours run counter-clockwise from the lower left, the detector's clockwise.
      const auto detected = static_cast<size_t>((3 - k + order.quarter) % 4);
      out.push_back({4 * place + k, tag.corners[detected]});
    }
  }
  return out;
}

// Root mean square distance from a homography of the board, as a share of the board's size in the
// image; infinite for a board that is seen from behind.
double Misfit(const Board& board, const std::vector<BoardCorner>& corners) {
  std::vector<cv::Point2d> on_board, in_image;
  for (const BoardCorner& corner : corners) {
    const Eigen::Vector2d p = board.CornerAt(corner.index);
    on_board.emplace_back(p.x(), p.y());
    in_image.emplace_back(corner.pixel.x(), corner.pixel.y());
  }
  const cv::Mat H = cv::findHomography(on_board, in_image, 0);
  // y is up on the board and down in the image: seen from the front it mirrors.
  if (H.empty() || cv::determinant(H) >= 0) {
    return std::numeric_limits<double>::infinity();
  }
  std::vector<cv::Point2d> expected;
  cv::perspectiveTransform(on_board, expected, H);
  double sum = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    const cv::Point2d d = expected[i] - in_image[i];
    sum += d.dot(d);
  }
  const cv::Rect2f box =
      cv::boundingRect(std::vector<cv::Point2f>(in_image.begin(), in_image.end()));
  return std::sqrt(sum / static_cast<double>(corners.size())) / std::hypot(box.width, box.height);
}

}  // namespace

Eigen::Vector2d Board::CornerAt(int index) const {
  if (kind == Kind::kCheckerboard) {
    return size_m * Eigen::Vector2d(index % columns, index / columns);
  }
  const int tag = index / 4;
  const int corner = index % 4;
  const Eigen::Vector2d lower_left =
      size_m * (1 + gap) * Eigen::Vector2d(tag % columns, tag / columns);
  return lower_left +
         size_m * Eigen::Vector2d(corner == 1 || corner == 2 ? 1 : 0, corner >= 2 ? 1 : 0);
}

Result<Board> ParseBoard(const std::string& text) {
  Board board;
  std::istringstream in(text);
  std::string kind;
  char x = 0, colon_1 = 0, colon_2 = 0;
  std::getline(in, kind, ':');
  in >> board.columns >> x >> board.rows >> colon_1 >> board.size_m;
  const bool tags = kind == "apriltag";
  if (tags) in >> colon_2 >> board.gap;
  std::string rest;
  const bool parsed = !in.fail() && !(in >> rest);
  board.kind = tags ? Board::Kind::kAprilTags : Board::Kind::kCheckerboard;
  const bool fine = parsed && (tags || kind == "checkerboard") && x == 'x' && colon_1 == ':' &&
                    (!tags || colon_2 == ':') && board.columns >= (tags ? 1 : 3) &&
                    board.rows >= (tags ? 1 : 3) && board.columns <= kLargestSide &&
                    board.rows <= kLargestSide && board.size_m > 0.001 && board.size_m < 2 &&
                    board.gap >= 0 && board.gap < 5;
  if (fine) return board;
  return Error{
      ErrorCode::kInvalidArgument,
      "--board " + text +
          ": expected apriltag:COLUMNSxROWS:SIDE_M:GAP (as apriltag:6x6:0.088:0.3) or "
          "checkerboard:COLUMNSxROWS:SIDE_M with inner corners (as checkerboard:8x5:0.03)"};
}

BoardFinder::BoardFinder(const Board& board) : board_(board) {}

std::vector<BoardCorner> BoardFinder::Find(const cv::Mat& grey) {
  return board_.kind == Board::Kind::kAprilTags ? FindTags(grey) : FindSquares(grey);
}

std::vector<BoardCorner> BoardFinder::FindTags(const cv::Mat& grey) {
  const int scale = grey.cols < kWideEnough ? 2 : 1;
  cv::Mat large = grey;
  if (scale > 1) cv::resize(grey, large, {}, scale, scale, cv::INTER_CUBIC);
  std::vector<SeenTag> tags;
  // AprilRobotics' tags have a border of one bit, those of Kalibr's grids of two.
  for (const int bits : {1, 2}) {
    if (border_bits_ != 0 && bits != border_bits_) continue;
    for (const int darker : kDarker) {
      auto found = DetectTags(large, bits, darker);
      if (found.size() <= tags.size()) continue;
      tags = std::move(found);
      if (tags.size() >= 3) border_bits_ = bits;
    }
  }
  for (SeenTag& tag : tags) {
    // Pixel centres are at whole numbers.
    for (Eigen::Vector2d& p : tag.corners) p = (p.array() + 0.5) / scale - 0.5;
  }
  tags = WithSharpCorners(grey, tags);
  std::vector<BoardCorner> best;
  double least = kLargestMisfit;
  for (const bool downwards : {false, true}) {
    for (int quarter = 0; quarter < 4; ++quarter) {
      auto corners = InOrder(board_, tags, {quarter, downwards});
      if (std::ssize(corners) < kFewestCorners) continue;
      const double misfit = Misfit(board_, corners);
      if (misfit >= least) continue;
      least = misfit;
      best = std::move(corners);
    }
  }
  return best;
}

std::vector<BoardCorner> BoardFinder::FindSquares(const cv::Mat& grey) const {
  std::vector<cv::Point2f> corners;
  const cv::Size size(board_.columns, board_.rows);
  if (!cv::findChessboardCornersSB(
          grey, size, corners,
          cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_ACCURACY | cv::CALIB_CB_EXHAUSTIVE)) {
    return {};
  }
  const cv::Point2f side = corners[1] - corners[0];
  const int half = std::clamp(static_cast<int>(std::hypot(side.x, side.y) / 5), 2, 8);
  cv::cornerSubPix(grey, corners, {half, half}, {-1, -1},
                   {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 50, 1e-4});
  // Turned by half a circle the board looks the same: its rows run to the right of the image.
  const cv::Point2f along = corners[static_cast<size_t>(board_.columns - 1)] - corners[0];
  if (along.x < 0) std::reverse(corners.begin(), corners.end());
  std::vector<BoardCorner> out;
  for (int i = 0; i < board_.num_corners(); ++i) {
    const cv::Point2f& at = corners[static_cast<size_t>(i)];
    out.push_back({i, {at.x, at.y}});
  }
  // Rows may run downwards: then the board is seen mirrored.
  if (Misfit(board_, out) <= kLargestMisfit) return out;
  for (BoardCorner& corner : out) {
    const int row = corner.index / board_.columns;
    corner.index = (board_.rows - 1 - row) * board_.columns + corner.index % board_.columns;
  }
  if (Misfit(board_, out) <= kLargestMisfit) return out;
  return {};
}

}  // namespace gw::calibrate

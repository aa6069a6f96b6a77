// Intrinsics of one camera, or of two and the pose between them, from images of a board: one
// least-squares problem (Ceres) over lenses, the pose of the board in each view, and the pose
// between the eyes, with its covariance.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "common/core/se3.h"
#include "tools/lab/calibrate/board.h"
#include "tools/lab/calibrate/lens.h"

namespace gw::calibrate {

// The board as each eye saw it at one instant; right is empty with one camera, or where it did not
// see the board.
struct BoardView {
  std::string name;  // of the image
  std::vector<BoardCorner> left, right;
};

struct LensEstimate {
  std::array<double, kMaxLensParameters> values{};  // in the order of LensParameterNames
  std::array<double, kMaxLensParameters> sigmas{};
  double rms_px = 0;  // root mean square distance of a corner from its projection
};

struct CameraEstimate {
  LensModel model = LensModel::kRadtan;
  int width = 0, height = 0;
  LensEstimate left;
  std::optional<LensEstimate> right;
  SE3 T_C0C1;                                    // of two eyes
  Vector6d sigmas_C0C1 = Vector6d::Zero();       // its tangent, [m; rad], on the right
  int views = 0;                                 // that were used
  std::vector<std::string> left_out;             // views whose corners do not fit
  double coverage_left = 0, coverage_right = 0;  // share of the image's cells (8 x 6) with a corner
};

// Both eyes have one size. Views that fit far worse than the others are left out. Error kBadData:
// too few views, or they do not determine a camera; says what to do.
Result<CameraEstimate> CalibrateCamera(const Board& board, LensModel model, int width, int height,
                                       std::vector<BoardView> views);

// What is wanting, each with what to do; empty when the calibration is good.
std::vector<std::string> JudgeCamera(const CameraEstimate& found);

}  // namespace gw::calibrate

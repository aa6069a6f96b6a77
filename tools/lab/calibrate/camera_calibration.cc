#include "tools/lab/calibrate/camera_calibration.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <set>

#include "common/core/median.h"
#include "tools/data/files/format.h"
#include "tools/lab/calibrate/tag_corners.h"

namespace gw::calibrate {
namespace {

using tools::Format;

constexpr int kFewestViews = 5;
constexpr double kDegrees = 180 / M_PI;
constexpr int kCellsX = 8, kCellsY = 6;
// A view whose corners are off by this many times the median view's was moved, or is no board.
constexpr double kOddView = 4;
// What is printed on both sides of a tag's thin border shifts its sides by some hundredths of a
// pixel, all corners of a tag alike, which the scatter of the corners does not show. Standard
// deviation of the focal length's relative error over 24 rendered calibrations with other poses
// than those of the tests (both lens models, both borders, tags of 20 to 50 px).
constexpr double kTagFocalError = 6e-4;

using Pose = std::array<double, 6>;  // rotation vector, translation: p_C = R p_board + t

// One corner of one view in one eye.
struct CornerCost {
  LensModel model;
  Eigen::Vector2d on_board, pixel;

  template <typename T>
  bool Project(const T* lens, const T* p_C, T* r) const {
    if (!ProjectThroughLens(model, lens, p_C, r)) return false;
    r[0] -= pixel.x();
    r[1] -= pixel.y();
    return true;
  }
  // In the left eye.
  template <typename T>
  bool operator()(const T* lens, const T* board, T* r) const {
    const T point[3] = {T(on_board.x()), T(on_board.y()), T(0)};
    T p_C[3];
    ceres::AngleAxisRotatePoint(board, point, p_C);
    for (int i = 0; i < 3; ++i) p_C[i] += board[3 + i];
    return Project(lens, p_C, r);
  }
};

// In the right eye: eyes is the pose of the left in the right, p_C1 = R p_C0 + t.
struct RightCornerCost {
  CornerCost corner;

  template <typename T>
  bool operator()(const T* lens, const T* board, const T* eyes, T* r) const {
    const T point[3] = {T(corner.on_board.x()), T(corner.on_board.y()), T(0)};
    T p_C0[3], p_C1[3];
    ceres::AngleAxisRotatePoint(board, point, p_C0);
    for (int i = 0; i < 3; ++i) p_C0[i] += board[3 + i];
    ceres::AngleAxisRotatePoint(eyes, p_C0, p_C1);
    for (int i = 0; i < 3; ++i) p_C1[i] += eyes[3 + i];
    return corner.Project(lens, p_C1, r);
  }
};

using Lens = std::array<double, kMaxLensParameters>;

SE3 ToSE3(const Pose& pose) {
  return SE3(ExpSO3({pose[0], pose[1], pose[2]}), {pose[3], pose[4], pose[5]});
}

Pose FromSE3(const SE3& T) {
  const Eigen::Vector3d r = LogSO3(T.rotation());
  const Eigen::Vector3d& p = T.translation();
  return {r.x(), r.y(), r.z(), p.x(), p.y(), p.z()};
}

// Pose of the board from the corners of one view, by a lens without distortion. Empty where too few
// corners are within 80 degrees of the axis.
std::optional<Pose> FirstPose(const Board& board, LensModel model, const Lens& lens,
                              const std::vector<BoardCorner>& corners) {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> rays;
  for (const BoardCorner& corner : corners) {
    const Eigen::Vector2d on_board = board.CornerAt(corner.index);
    Eigen::Vector2d ray((corner.pixel.x() - lens[2]) / lens[0],
                        (corner.pixel.y() - lens[3]) / lens[1]);
    const double theta = ray.norm();
    if (model == LensModel::kEquidistant && theta > 1e-9) {
      if (theta > 80 / kDegrees) continue;
      ray *= std::tan(theta) / theta;
    }
    points.emplace_back(on_board.x(), on_board.y(), 0);
    rays.emplace_back(ray.x(), ray.y());
  }
  if (std::ssize(points) < BoardFinder::kFewestCorners) return std::nullopt;
  cv::Mat r, t;
  if (!cv::solvePnP(points, rays, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), r, t)) {
    return std::nullopt;
  }
  if (t.at<double>(2) <= 0) return std::nullopt;
  return Pose{r.at<double>(0), r.at<double>(1), r.at<double>(2),
              t.at<double>(0), t.at<double>(1), t.at<double>(2)};
}

double SquaredErrors(const Board& board, LensModel model, const Lens& lens, const Pose& pose,
                     const std::vector<BoardCorner>& corners) {
  double sum = 0;
  for (const BoardCorner& corner : corners) {
    double r[2];
    const CornerCost cost{model, board.CornerAt(corner.index), corner.pixel};
    if (!cost(lens.data(), pose.data(), r)) return std::numeric_limits<double>::infinity();
    sum += r[0] * r[0] + r[1] * r[1];
  }
  return sum;
}

using Views = std::vector<const std::vector<BoardCorner>*>;

// The focal length of a lens without distortion that explains the views best, of a row of guesses a
// fifth apart: from a fisheye of 200 degrees to a narrow lens.
Lens FirstLens(const Board& board, LensModel model, int width, int height, const Views& views) {
  Lens best{};
  double least = std::numeric_limits<double>::infinity();
  for (double share = 0.28; share < 4; share *= 1.2) {
    Lens lens{};
    lens[0] = lens[1] = share * width;
    lens[2] = (width - 1) / 2.0;
    lens[3] = (height - 1) / 2.0;
    double sum = 0;
    for (const auto* corners : views) {
      if (corners->empty()) continue;
      const auto pose = FirstPose(board, model, lens, *corners);
      // A view that this lens does not explain at all counts as a hundred pixels.
      sum += pose ? SquaredErrors(board, model, lens, *pose, *corners)
                  : 1e4 * static_cast<double>(corners->size());
    }
    if (sum < least) {
      least = sum;
      best = lens;
    }
  }
  return best;
}

// All unknowns.
struct State {
  Lens left{}, right{};
  Pose eyes{};  // left in right
  std::vector<Pose> boards;
};

class Adjustment {
 public:
  Adjustment(const Board& board, LensModel model, const std::vector<BoardView>& views, State* state)
      : board_(board), model_(model), state_(*state) {
    for (size_t v = 0; v < views.size(); ++v) {
      for (const BoardCorner& corner : views[v].left) AddLeft(v, corner);
      for (const BoardCorner& corner : views[v].right) AddRight(v, corner);
    }
    // The ninth number of a lens with eight parameters.
    if (model == LensModel::kEquidistant) {
      for (double* lens : {state_.left.data(), state_.right.data()}) {
        if (problem_.HasParameterBlock(lens)) {
          problem_.SetManifold(lens, new ceres::SubsetManifold(kMaxLensParameters, {8}));
        }
      }
    }
  }

  void Solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-12;
    options.parameter_tolerance = 1e-12;
    options.num_threads = 1;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
  }

  // Variances of lenses and eyes, by the scatter of the residuals; empty when the views do not
  // determine them.
  std::optional<Eigen::MatrixXd> Covariance() {
    std::vector<double*> blocks = {state_.left.data()};
    if (problem_.HasParameterBlock(state_.right.data())) {
      blocks.push_back(state_.right.data());
      blocks.push_back(state_.eyes.data());
    }
    std::vector<const double*> asked(blocks.begin(), blocks.end());
    ceres::Covariance::Options options;
    options.algorithm_type = ceres::SPARSE_QR;
    ceres::Covariance covariance(options);
    if (!covariance.Compute(asked, &problem_)) return std::nullopt;
    const Eigen::Index n = blocks.size() == 1 ? kMaxLensParameters : 2 * kMaxLensParameters + 6;
    Eigen::MatrixXd out(n, n);
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows(n, n);
    covariance.GetCovarianceMatrix(asked, rows.data());
    out = rows;
    double cost = 0;
    problem_.Evaluate({}, &cost, nullptr, nullptr, nullptr);
    const double free = problem_.NumResiduals() - problem_.NumParameters();
    return out * (2 * cost / std::max(1.0, free));
  }

 private:
  CornerCost Cost(const BoardCorner& corner) const {
    return {model_, board_.CornerAt(corner.index), corner.pixel};
  }
  void AddLeft(size_t view, const BoardCorner& corner) {
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<CornerCost, 2, kMaxLensParameters, 6>(
                                  new CornerCost(Cost(corner))),
                              Loss(), state_.left.data(), state_.boards[view].data());
  }
  void AddRight(size_t view, const BoardCorner& corner) {
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<RightCornerCost, 2, kMaxLensParameters, 6, 6>(
            new RightCornerCost{Cost(corner)}),
        Loss(), state_.right.data(), state_.boards[view].data(), state_.eyes.data());
  }
  // Corners are wrong by whole pixels or not at all.
  static ceres::LossFunction* Loss() { return new ceres::HuberLoss(1.0); }

  const Board& board_;
  LensModel model_;
  State& state_;
  ceres::Problem problem_;
};

// Sum of squares and number of corners of each view, per eye.
struct ViewErrors {
  double left = 0, right = 0;
};

ViewErrors ErrorsOf(const Board& board, LensModel model, const State& state, size_t v,
                    const BoardView& view) {
  const SE3 T_C0Board = ToSE3(state.boards[v]);
  const Pose in_right = FromSE3(ToSE3(state.eyes) * T_C0Board);
  return {SquaredErrors(board, model, state.left, state.boards[v], view.left),
          view.right.empty() ? 0 : SquaredErrors(board, model, state.right, in_right, view.right)};
}

double ViewRms(const Board& board, LensModel model, const State& state, size_t v,
               const BoardView& view) {
  const ViewErrors errors = ErrorsOf(board, model, state, v, view);
  const auto corners = static_cast<double>(view.left.size() + view.right.size());
  return std::sqrt((errors.left + errors.right) / corners);
}

// Starts all unknowns from the views; leaves out views in which the left eye has no pose.
State Begin(const Board& board, LensModel model, int width, int height,
            std::vector<BoardView>* views) {
  Views left, right;
  for (const BoardView& view : *views) {
    left.push_back(&view.left);
    right.push_back(&view.right);
  }
  State state;
  state.left = FirstLens(board, model, width, height, left);
  state.right = FirstLens(board, model, width, height, right);
  std::vector<BoardView> kept;
  std::vector<SE3> eyes;
  for (BoardView& view : *views) {
    const auto pose = FirstPose(board, model, state.left, view.left);
    if (!pose) continue;
    state.boards.push_back(*pose);
    const auto other =
        view.right.empty() ? std::nullopt : FirstPose(board, model, state.right, view.right);
    if (!other) view.right.clear();
    if (other) eyes.push_back(ToSE3(*other) * ToSE3(*pose).inverse());
    kept.push_back(std::move(view));
  }
  *views = std::move(kept);
  if (eyes.empty()) return state;
  // The view in the middle of all.
  std::sort(eyes.begin(), eyes.end(), [](const SE3& a, const SE3& b) {
    return a.translation().norm() < b.translation().norm();
  });
  state.eyes = FromSE3(eyes[eyes.size() / 2]);
  return state;
}

// Leaves out views that fit far worse than the others; true when there were any.
bool LeaveOutOddViews(const Board& board, LensModel model, State* state,
                      std::vector<BoardView>* views, std::vector<std::string>* left_out) {
  std::vector<double> rms;
  for (size_t v = 0; v < views->size(); ++v) {
    rms.push_back(ViewRms(board, model, *state, v, (*views)[v]));
  }
  std::vector<double> sorted = rms;
  const double limit = kOddView * MedianOf(&sorted);
  State kept_state = *state;
  kept_state.boards.clear();
  std::vector<BoardView> kept;
  for (size_t v = 0; v < views->size(); ++v) {
    if (rms[v] > limit) {
      left_out->push_back((*views)[v].name);
      continue;
    }
    kept_state.boards.push_back(state->boards[v]);
    kept.push_back(std::move((*views)[v]));
  }
  const bool any = kept.size() < views->size();
  *state = std::move(kept_state);
  *views = std::move(kept);
  return any;
}

// Takes what bending by the lens did to the corners of tags out of the corners of one eye; `seen`
// are the corners as they were found.
void TakeOutBending(const Board& board, LensModel model, const Lens& lens, const SE3& T_CBoard,
                    const std::vector<BoardCorner>& seen, std::vector<BoardCorner>* corrected) {
  const auto project = [&](const Eigen::Vector2d& on_board) -> std::optional<Eigen::Vector2d> {
    const Eigen::Vector3d p = T_CBoard * Eigen::Vector3d(on_board.x(), on_board.y(), 0);
    Eigen::Vector2d pixel;
    if (!ProjectThroughLens(model, lens.data(), p.data(), pixel.data())) return std::nullopt;
    return pixel;
  };
  for (size_t i = 0; i < seen.size(); ++i) {
    const int tag = seen[i].index / 4, k = seen[i].index % 4;
    const Eigen::Vector2d corner = board.CornerAt(seen[i].index);
    const auto here = project(corner);
    std::vector<BentSide> sides;
    for (const int neighbour : {(k + 1) % 4, (k + 3) % 4}) {
      const Eigen::Vector2d other = board.CornerAt(4 * tag + neighbour);
      const auto middle = project((corner + other) / 2), there = project(other);
      if (here && middle && there) sides.push_back({*here, *middle, *there});
    }
    if (sides.size() < 2) continue;
    (*corrected)[i].pixel = seen[i].pixel - OffsetByBending(sides[0], sides[1]);
  }
}

// Solves with the corners of tags where they are, not where straight sides would meet. The second
// round changes the first one's correction by its error in percent.
void SolveWithoutBending(const Board& board, LensModel model, State* state,
                         std::vector<BoardView>* views) {
  const std::vector<BoardView> seen = *views;
  for (int round = 0; round < 2; ++round) {
    for (size_t v = 0; v < seen.size(); ++v) {
      const SE3 T_C0Board = ToSE3(state->boards[v]);
      BoardView& view = (*views)[v];
      TakeOutBending(board, model, state->left, T_C0Board, seen[v].left, &view.left);
      TakeOutBending(board, model, state->right, ToSE3(state->eyes) * T_C0Board, seen[v].right,
                     &view.right);
    }
    Adjustment(board, model, *views, state).Solve();
  }
}

double Coverage(const std::vector<BoardView>& views, std::vector<BoardCorner> BoardView::*eye,
                int width, int height) {
  std::set<int> cells;
  for (const BoardView& view : views) {
    for (const BoardCorner& corner : view.*eye) {
      const int x =
          std::clamp(static_cast<int>(corner.pixel.x() * kCellsX / width), 0, kCellsX - 1);
      const int y =
          std::clamp(static_cast<int>(corner.pixel.y() * kCellsY / height), 0, kCellsY - 1);
      cells.insert(y * kCellsX + x);
    }
  }
  return static_cast<double>(cells.size()) / (kCellsX * kCellsY);
}

LensEstimate EstimateOf(const Lens& lens, const Eigen::MatrixXd& covariance, Eigen::Index at,
                        double squares, size_t corners) {
  LensEstimate out;
  out.values = lens;
  for (size_t i = 0; i < lens.size(); ++i) {
    const auto k = at + static_cast<Eigen::Index>(i);
    out.sigmas[i] = std::sqrt(std::max(0.0, covariance(k, k)));
  }
  out.rms_px = std::sqrt(squares / static_cast<double>(std::max<size_t>(1, corners)));
  return out;
}

void AddFocalErrorOfTags(LensEstimate* eye) {
  for (const size_t i : {0UL, 1UL}) {
    eye->sigmas[i] = std::hypot(eye->sigmas[i], kTagFocalError * eye->values[i]);
  }
}

void FillEstimate(const Board& board, const State& state, const std::vector<BoardView>& views,
                  const Eigen::MatrixXd& covariance, CameraEstimate* out) {
  ViewErrors errors;
  size_t left_corners = 0, right_corners = 0;
  for (size_t v = 0; v < views.size(); ++v) {
    const ViewErrors view = ErrorsOf(board, out->model, state, v, views[v]);
    errors.left += view.left;
    errors.right += view.right;
    left_corners += views[v].left.size();
    right_corners += views[v].right.size();
  }
  out->left = EstimateOf(state.left, covariance, 0, errors.left, left_corners);
  out->coverage_left = Coverage(views, &BoardView::left, out->width, out->height);
  out->views = static_cast<int>(views.size());
  if (right_corners == 0) return;
  out->right = EstimateOf(state.right, covariance, kMaxLensParameters, errors.right, right_corners);
  out->coverage_right = Coverage(views, &BoardView::right, out->width, out->height);
  const SE3 T_C1C0 = ToSE3(state.eyes);
  out->T_C0C1 = T_C1C0.inverse();
  // A change dr of the rotation vector (small, so that it adds like a turn on the left) and dt of
  // the translation is [dt + t x dr; dr] on the left of T_C1C0, and minus that on the right of its
  // inverse.
  const Eigen::Vector3d& t = T_C1C0.translation();
  Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Zero();
  J.topLeftCorner<3, 3>() << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  J.topRightCorner<3, 3>() = Eigen::Matrix3d::Identity();
  J.bottomLeftCorner<3, 3>() = Eigen::Matrix3d::Identity();
  const Eigen::Matrix<double, 6, 6> C = covariance.bottomRightCorner<6, 6>();
  const Eigen::Matrix<double, 6, 6> tangent = J * C * J.transpose();
  out->sigmas_C0C1 = tangent.diagonal().cwiseMax(0).cwiseSqrt();
}

}  // namespace

Result<CameraEstimate> CalibrateCamera(const Board& board, LensModel model, int width, int height,
                                       std::vector<BoardView> views) {
  const auto few = [](size_t count, const char* what) {
    return Error{ErrorCode::kBadData,
                 Format("the board is usable in %d %s, at least %d are needed: show all of it, "
                        "sharp, at a third to all of the image's width, tilted by 20 to 45 degrees "
                        "to all sides",
                        count, what, kFewestViews)};
  };
  const bool stereo =
      std::any_of(views.begin(), views.end(), [](const BoardView& v) { return !v.right.empty(); });
  std::erase_if(views, [](const BoardView& view) { return view.left.empty(); });
  if (std::ssize(views) < kFewestViews) return few(views.size(), "images");
  State state = Begin(board, model, width, height, &views);
  if (std::ssize(views) < kFewestViews) return few(views.size(), "images");
  CameraEstimate out;
  out.model = model;
  out.width = width;
  out.height = height;
  for (int round = 0; round < 3; ++round) {
    Adjustment(board, model, views, &state).Solve();
    if (!LeaveOutOddViews(board, model, &state, &views, &out.left_out)) break;
    if (std::ssize(views) < kFewestViews) return few(views.size(), "images that fit each other");
  }
  if (board.kind == Board::Kind::kAprilTags) SolveWithoutBending(board, model, &state, &views);
  Adjustment adjustment(board, model, views, &state);
  adjustment.Solve();
  const std::optional<Eigen::MatrixXd> covariance = adjustment.Covariance();
  const auto pairs = std::count_if(views.begin(), views.end(),
                                   [](const BoardView& v) { return !v.right.empty(); });
  if (stereo && pairs < kFewestViews) return few(static_cast<size_t>(pairs), "pairs of images");
  if (!covariance) {
    return Error{ErrorCode::kBadData,
                 "these views do not determine a camera: tilt the board by 20 to 45 degrees to all "
                 "sides, near and far"};
  }
  FillEstimate(board, state, views, *covariance, &out);
  if (board.kind == Board::Kind::kAprilTags) {
    AddFocalErrorOfTags(&out.left);
    if (out.right) AddFocalErrorOfTags(&*out.right);
  }
  return out;
}

namespace {

void JudgeEye(const char* name, const CameraEstimate& found, const LensEstimate& eye,
              double coverage, std::vector<std::string>* out) {
  if (eye.rms_px > 0.5) {
    out->push_back(
        Format("%s: corners are off by %.2f px (below 0.3 is usual): blurred images, a "
               "board that is not flat, or the other lens model",
               name, eye.rms_px));
  }
  if (eye.sigmas[0] > 0.003 * eye.values[0]) {
    out->push_back(
        Format("%s: the focal length is known to %.1f %% only: tilt the board by 20 to 45 "
               "degrees to all sides",
               name, 100 * eye.sigmas[0] / eye.values[0]));
  }
  if (std::max(eye.sigmas[2], eye.sigmas[3]) > 0.005 * found.width) {
    out->push_back(
        Format("%s: the principal point is known to %.1f px only: tilt the board to all "
               "sides, and turn it upright and flat",
               name, std::max(eye.sigmas[2], eye.sigmas[3])));
  }
  if (coverage < 0.75) {
    out->push_back(
        Format("%s: the board was seen in %.0f %% of the image's parts: bring it into "
               "every corner, where distortion is strongest",
               name, 100 * coverage));
  }
}

}  // namespace

std::vector<std::string> JudgeCamera(const CameraEstimate& found) {
  std::vector<std::string> out;
  JudgeEye(found.right ? "left" : "camera", found, found.left, found.coverage_left, &out);
  if (found.right) {
    JudgeEye("right", found, *found.right, found.coverage_right, &out);
    const double baseline = found.T_C0C1.translation().norm();
    if (found.sigmas_C0C1.head<3>().norm() > 0.01 * baseline) {
      out.push_back(
          Format("the baseline of %.4f m is known to %.1f mm only: more pairs, the board "
                 "nearer",
                 baseline, 1e3 * found.sigmas_C0C1.head<3>().norm()));
    }
    if (found.T_C0C1.translation().x() < 0) {
      out.push_back("the right eye is left of the left one: the folders of the eyes are swapped");
    }
  }
  if (found.views < 15) {
    out.push_back(Format("%d views: 15 to 40 make the result independent of which", found.views));
  }
  return out;
}

}  // namespace gw::calibrate

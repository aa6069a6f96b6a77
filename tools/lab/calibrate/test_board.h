// Images of calibration boards through known lenses, rendered for the tests of this folder.
#pragma once

#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/core/random.h"
#include "common/core/se3.h"
#include "tools/lab/calibrate/board.h"
#include "tools/lab/calibrate/lens.h"

namespace gw::calibrate {

struct TestLens {
  LensModel model = LensModel::kRadtan;
  std::array<double, kMaxLensParameters> values{};
};

// How tags are printed.
struct PrintStyle {
  int border_bits = 1;
  bool corner_squares = false;  // black squares between the tags, as Kalibr prints
};

// Grey of a board at a place of its plane (m).
class BoardPaint {
 public:
  BoardPaint(const Board& board, const PrintStyle& style) : board_(board), style_(style) {
    const auto family = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11);
    for (int id = 0; board.kind == Board::Kind::kAprilTags && id < board.columns * board.rows;
         ++id) {
      cv::Mat image;
      cv::aruco::drawMarker(family, id, cells(), image, style.border_bits);
      tags_.push_back(image);
    }
  }

  int At(const Eigen::Vector2d& p) const {
    return board_.kind == Board::Kind::kAprilTags ? AtTags(p) : AtSquares(p);
  }

 private:
  static constexpr int kWhite = 235, kBlack = 20;
  int cells() const { return 6 + 2 * style_.border_bits; }

  int AtTags(const Eigen::Vector2d& p) const {
    const double pitch = board_.size_m * (1 + board_.gap);
    const int column = static_cast<int>(std::floor(p.x() / pitch));
    const int row = static_cast<int>(std::floor(p.y() / pitch));
    const Eigen::Vector2d in = p - pitch * Eigen::Vector2d(column, row);
    const double gap = pitch - board_.size_m;
    if (style_.corner_squares && AtCornerSquare(p, pitch, gap)) return kBlack;
    if (column < 0 || row < 0 || column >= board_.columns || row >= board_.rows) return kWhite;
    if (in.x() >= board_.size_m || in.y() >= board_.size_m) return kWhite;
    const int x = static_cast<int>(in.x() / board_.size_m * cells());
    const int y = cells() - 1 - static_cast<int>(in.y() / board_.size_m * cells());
    const cv::Mat& tag = tags_[static_cast<size_t>(row) * static_cast<size_t>(board_.columns) +
                               static_cast<size_t>(column)];
    return tag.at<uint8_t>(y, x) > 127 ? kWhite : kBlack;
  }
  bool AtCornerSquare(const Eigen::Vector2d& p, double pitch, double gap) const {
    const double x = p.x() + gap, y = p.y() + gap;
    return x >= 0 && y >= 0 && x < board_.columns * pitch + gap && y < board_.rows * pitch + gap &&
           std::fmod(x, pitch) < gap && std::fmod(y, pitch) < gap;
  }
  int AtSquares(const Eigen::Vector2d& p) const {
    const double x = p.x() / board_.size_m + 1, y = p.y() / board_.size_m + 1;
    if (x < 0 || y < 0 || x >= board_.columns + 1 || y >= board_.rows + 1) return kWhite;
    return (static_cast<int>(x) + static_cast<int>(y)) % 2 == 0 ? kBlack : kWhite;
  }

  Board board_;
  PrintStyle style_;
  std::vector<cv::Mat> tags_;
};

// Renders boards through one lens. Each pixel is the mean of kSamples^2 rays, blurred a little,
// with noise of two grey values.
class BoardCamera {
 public:
  BoardCamera(const TestLens& lens, int width, int height) : width_(width), height_(height) {
    for (int v = 0; v < height * kSamples; ++v) {
      // From the neighbour's ray, and in a new row from that of a lens without distortion.
      const double y = (v + 0.5) / kSamples - 0.5;
      Eigen::Vector2d ray((-0.5 - lens.values[2]) / lens.values[0],
                          (y - lens.values[3]) / lens.values[1]);
      for (int u = 0; u < width * kSamples; ++u) {
        rays_.push_back(RayOf(lens, {(u + 0.5) / kSamples - 0.5, y}, &ray));
      }
    }
  }

  cv::Mat Look(const BoardPaint& paint, const SE3& T_CBoard, uint64_t seed) const {
    const SE3 T_BoardC = T_CBoard.inverse();
    const Eigen::Vector3d& eye = T_BoardC.translation();
    const Eigen::Matrix3d R = T_BoardC.rotation().toRotationMatrix();
    cv::Mat grey(height_, width_, CV_32F, cv::Scalar(0));
    size_t ray = 0;
    for (int v = 0; v < height_ * kSamples; ++v) {
      for (int u = 0; u < width_ * kSamples; ++u, ++ray) {
        const Eigen::Vector3d d = R * rays_[ray].cast<double>();
        double value = 110;  // of the wall behind
        if (d.z() * eye.z() < 0) {
          const Eigen::Vector3d hit = eye - d * (eye.z() / d.z());
          if (hit.head<2>().cwiseAbs().maxCoeff() < 1) value = paint.At(hit.head<2>());
        }
        grey.at<float>(v / kSamples, u / kSamples) +=
            static_cast<float>(value / (kSamples * kSamples));
      }
    }
    cv::GaussianBlur(grey, grey, {0, 0}, 0.7);
    CounterRng rng(seed, 11, 4);
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u) {
        grey.at<float>(v, u) += static_cast<float>(2 * rng.Normal());
      }
    }
    cv::Mat out;
    grey.convertTo(out, CV_8U);
    return out;
  }

 private:
  static constexpr int kSamples = 3;

  // Newton's method on the projection. *ray: its x/z and y/z, of a fisheye the angle from the axis
  // along x and y; the start, and the result.
  static Eigen::Vector3f RayOf(const TestLens& lens, const Eigen::Vector2d& pixel,
                               Eigen::Vector2d* ray) {
    const auto lift = [&](const Eigen::Vector2d& a) -> Eigen::Vector3d {
      if (lens.model == LensModel::kRadtan) return {a.x(), a.y(), 1};
      const double theta = a.norm();
      const double scale = theta > 1e-12 ? std::sin(theta) / theta : 1;
      return {a.x() * scale, a.y() * scale, std::cos(theta)};
    };
    const auto project = [&](const Eigen::Vector2d& a) {
      const Eigen::Vector3d p = lift(a);
      Eigen::Vector2d at(1e6, 1e6);
      ProjectThroughLens(lens.model, lens.values.data(), p.data(), at.data());
      return at;
    };
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector2d at = project(*ray);
      if ((at - pixel).norm() < 1e-7) break;
      constexpr double kStep = 1e-6;
      Eigen::Matrix2d J;
      J.col(0) = (project(*ray + Eigen::Vector2d(kStep, 0)) - at) / kStep;
      J.col(1) = (project(*ray + Eigen::Vector2d(0, kStep)) - at) / kStep;
      *ray -= J.inverse() * (at - pixel);
    }
    return lift(*ray).cast<float>();
  }

  int width_, height_;
  std::vector<Eigen::Vector3f> rays_;
};

// Poses of a board of this size in front of a camera: near the middle and in the corners of the
// field, tilted to all sides. T_CBoard, the board's middle at about `distance` m.
inline std::vector<SE3> PosesAround(const Board& board, double distance, double spread, int count,
                                    uint64_t seed) {
  CounterRng rng(seed, 2, 9);
  const Eigen::Vector2d middle =
      0.5 * (board.CornerAt(0) + board.CornerAt(board.num_corners() - 1));
  // The board's y is up, the camera's down.
  const Eigen::Quaterniond upright(0, 1, 0, 0);
  std::vector<SE3> out;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.399963 * i;  // the golden angle: even over the circle
    const double share = std::sqrt((i + 0.5) / count);
    const Eigen::Vector3d at(spread * share * std::cos(angle),
                             0.75 * spread * share * std::sin(angle),
                             distance * rng.Uniform(0.8, 1.3));
    const double tilt = 0.7 * rng.Uniform(0.3, 1.0), about = rng.Uniform(0, 6.28);
    const Eigen::Quaterniond q = ExpSO3({tilt * std::cos(about), tilt * std::sin(about), 0}) *
                                 ExpSO3({0, 0, rng.Uniform(-0.4, 0.4)}) * upright;
    const SE3 T_CM(q, at);
    out.push_back(T_CM * SE3(Eigen::Quaterniond::Identity(), {-middle.x(), -middle.y(), 0}));
  }
  return out;
}

}  // namespace gw::calibrate

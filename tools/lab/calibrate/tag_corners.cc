#include "tools/lab/calibrate/tag_corners.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

namespace gw::calibrate {
namespace {

using Eigen::Vector2d;

// Away from the corners, where blur and what is printed there do not reach.
constexpr double kFirst = 0.15, kLast = 0.85;
constexpr int kPlaces = 24;         // along a side
constexpr double kStep = 0.25;      // px, across
constexpr double kContrast = 20;    // grey values; less is no edge
constexpr double kStraight = 0.25;  // px, root mean square; more is no side of a square
constexpr int kRounds = 5;

// Half of the width that is searched across a side: with blur it stays within the black border,
// which is an eighth to a fifth of the tag's extent across that side.
double HalfWidth(double across_px) {
  return std::clamp(across_px / 16, 1.0, 4.0);
}

double GreyAt(const cv::Mat& grey, const Vector2d& p) {
  const int x = static_cast<int>(std::floor(p.x())), y = static_cast<int>(std::floor(p.y()));
  const double fx = p.x() - x, fy = p.y() - y;
  const uint8_t* const above = grey.ptr<uint8_t>(y);
  const uint8_t* const below = grey.ptr<uint8_t>(y + 1);
  return (1 - fy) * ((1 - fx) * above[x] + fx * above[x + 1]) +
         fy * ((1 - fx) * below[x] + fx * below[x + 1]);
}

bool Inside(const cv::Mat& grey, const Vector2d& p) {
  return p.x() >= 0 && p.y() >= 0 && p.x() < grey.cols - 1 && p.y() < grey.rows - 1;
}

// Distance from `at` along `outward` at which black becomes white: where the grey crosses the mean
// of both, which blur leaves in place.
std::optional<double> EdgeAcross(const cv::Mat& grey, const Vector2d& at, const Vector2d& outward,
                                 double half, double level) {
  if (!Inside(grey, at + half * outward) || !Inside(grey, at - half * outward)) return std::nullopt;
  double before = GreyAt(grey, at - half * outward);
  for (double s = -half + kStep; s <= half; s += kStep) {
    const double value = GreyAt(grey, at + s * outward);
    if (before < level && value >= level) {
      return s - kStep * (value - level) / (value - before);
    }
    before = value;
  }
  return std::nullopt;
}

// The mean of black and white along a side, each where it is purest: what is printed inside the
// border does not count. Empty where there is no contrast.
std::optional<double> LevelAlong(const cv::Mat& grey, const std::vector<Vector2d>& places,
                                 const Vector2d& outward, double half) {
  double black = 0, white = 0;
  int count = 0;
  for (const Vector2d& at : places) {
    if (!Inside(grey, at + half * outward) || !Inside(grey, at - half * outward)) continue;
    double darkest = 255, brightest = 0;
    for (double s = -half; s <= half; s += kStep) {
      const double value = GreyAt(grey, at + s * outward);
      darkest = std::min(darkest, value);
      brightest = std::max(brightest, value);
    }
    black += darkest;
    white += brightest;
    ++count;
  }
  if (count == 0 || white - black < kContrast * count) return std::nullopt;
  return (black + white) / (2 * count);
}

struct Line {
  Vector2d point, direction;
};

std::optional<Line> SideBetween(const cv::Mat& grey, const Vector2d& a, const Vector2d& b,
                                const Vector2d& middle) {
  const Vector2d along = b - a;
  Vector2d outward = Vector2d(along.y(), -along.x()).normalized();
  if (outward.dot(middle - a) > 0) outward = -outward;
  const double half = HalfWidth(-2 * outward.dot(middle - a));
  std::vector<Vector2d> places, edge;
  for (int i = 0; i < kPlaces; ++i) {
    places.push_back(a + along * (kFirst + (kLast - kFirst) * i / (kPlaces - 1)));
  }
  const auto level = LevelAlong(grey, places, outward, half);
  if (!level) return std::nullopt;
  for (const Vector2d& at : places) {
    const auto offset = EdgeAcross(grey, at, outward, half, *level);
    if (offset) edge.push_back(at + *offset * outward);
  }
  if (std::ssize(edge) < kPlaces / 2) return std::nullopt;
  Vector2d mean = Vector2d::Zero();
  for (const Vector2d& p : edge) mean += p / static_cast<double>(edge.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Vector2d& p : edge) scatter += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(scatter);
  const double off = std::sqrt(axes.eigenvalues()[0] / static_cast<double>(edge.size()));
  if (off > kStraight) return std::nullopt;
  return Line{mean, axes.eigenvectors().col(1)};
}

std::optional<Vector2d> Crossing(const Line& a, const Line& b) {
  Eigen::Matrix2d directions;
  directions << a.direction, -b.direction;
  if (std::abs(directions.determinant()) < 0.1) return std::nullopt;
  return a.point + a.direction * directions.inverse().row(0).dot(b.point - a.point);
}

}  // namespace

std::optional<std::array<Vector2d, 4>> CornersOfSquare(const cv::Mat& grey,
                                                       const std::array<Vector2d, 4>& corners) {
  std::array<Vector2d, 4> found = corners;
  for (int round = 0; round < kRounds; ++round) {
    const Vector2d middle = (found[0] + found[1] + found[2] + found[3]) / 4;
    std::array<std::optional<Line>, 4> sides;  // from each corner to the next
    for (size_t i = 0; i < 4; ++i) {
      sides[i] = SideBetween(grey, found[i], found[(i + 1) % 4], middle);
      if (!sides[i]) return std::nullopt;
    }
    for (size_t i = 0; i < 4; ++i) {
      const auto corner = Crossing(*sides[(i + 3) % 4], *sides[i]);
      if (!corner) return std::nullopt;
      found[i] = *corner;
    }
  }
  return found;
}

Vector2d OffsetByBending(const BentSide& a, const BentSide& b) {
  // Along a side u runs from -1 to 1, and the curve is sag (1 - u^2) off the chord. The line that
  // fits it best from -kReach to kReach is sag (1 - kReach^2 / 3) off.
  constexpr double kReach = kLast - kFirst;
  constexpr double kShare = 1 - kReach * kReach / 3;
  Eigen::Matrix2d normals;
  Vector2d off;
  const std::array<const BentSide*, 2> sides = {&a, &b};
  for (Eigen::Index i = 0; i < 2; ++i) {
    const BentSide& side = *sides[static_cast<size_t>(i)];
    const Vector2d along = (side.other - side.corner).normalized();
    normals.row(i) << -along.y(), along.x();
    off[i] = kShare * normals.row(i).dot(side.middle - (side.corner + side.other) / 2);
  }
  if (std::abs(normals.determinant()) < 0.1) return Vector2d::Zero();
  return normals.inverse() * off;
}

}  // namespace gw::calibrate

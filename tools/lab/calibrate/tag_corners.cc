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
constexpr int kRounds = 3;

// Half of the width that is searched across a side: stays within the black border, which is an
// eighth to a fifth of a side.
double HalfWidth(double side_px) {
  return std::clamp(side_px / 16, 1.5, 4.0);
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

// Distance from `at` along `outward` at which black becomes white: the mean of where the grey
// rises, weighted by how much.
std::optional<double> EdgeAcross(const cv::Mat& grey, const Vector2d& at, const Vector2d& outward,
                                 double half) {
  if (!Inside(grey, at + half * outward) || !Inside(grey, at - half * outward)) return std::nullopt;
  double before = GreyAt(grey, at - half * outward);
  double weight = 0, sum = 0;
  for (double s = -half + kStep; s <= half; s += kStep) {
    const double value = GreyAt(grey, at + s * outward);
    const double rise = std::max(0.0, value - before);
    weight += rise;
    sum += rise * (s - kStep / 2);
    before = value;
  }
  if (weight < kContrast) return std::nullopt;
  return sum / weight;
}

struct Line {
  Vector2d point, direction;
};

std::optional<Line> SideBetween(const cv::Mat& grey, const Vector2d& a, const Vector2d& b,
                                const Vector2d& middle) {
  const Vector2d along = b - a;
  Vector2d outward = Vector2d(along.y(), -along.x()).normalized();
  if (outward.dot(middle - a) > 0) outward = -outward;
  std::vector<Vector2d> edge;
  for (int i = 0; i < kPlaces; ++i) {
    const Vector2d at = a + along * (kFirst + (kLast - kFirst) * i / (kPlaces - 1));
    const auto offset = EdgeAcross(grey, at, outward, HalfWidth(along.norm()));
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

}  // namespace gw::calibrate

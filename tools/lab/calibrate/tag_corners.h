// Corners of a black square on white to a small part of a pixel.
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>

namespace gw::calibrate {

// Where lines through the square's sides meet. A corner by itself is rounded off by blur, which
// pulls it inwards by a quarter of a pixel and more; the middle of a side stays where it is. The
// corners given go round the square in either sense and are off by at most a sixteenth of a side.
// Empty where a side is not to be seen, or is no line.
std::optional<std::array<Eigen::Vector2d, 4>> CornersOfSquare(
    const cv::Mat& grey, const std::array<Eigen::Vector2d, 4>& corners);

// Three places of a side of a square, as a lens shows them (px).
struct BentSide {
  Eigen::Vector2d corner, middle, other;
};

// How far CornersOfSquare is off at the corner that two sides share, because a lens bends the sides
// that it takes for straight (px): by its line instead of a curve of second order. Zero where the
// sides are parallel.
Eigen::Vector2d OffsetByBending(const BentSide& a, const BentSide& b);

}  // namespace gw::calibrate

// Pixel of the camera's image -> pixel of the RectifiedCamera, from a table.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "common/camera/camera_model.h"

namespace gw::frontend {

class ImageUndistorter {
 public:
  // For a single camera whose rectified frame is its own (RGB-D): only the distortion goes.
  explicit ImageUndistorter(const CameraGeometry& geometry);

  // Nothing outside the image, and where the distortion cannot be inverted.
  std::optional<Eigen::Vector2f> Undistort(float u, float v) const;

 private:
  // Between the grid's nodes the distortion is interpolated linearly; with 4 px the error stays
  // below 0.02 px (0.011 px in the corners of a
  // Kinect, see image_undistorter_test.cc).
  static constexpr int kSpacing = 4;

  bool identity_ = true;
  int width_ = 0, height_ = 0;
  int columns_ = 0;
  std::vector<Eigen::Vector2f> shift_;  // undistorted minus distorted pixel; NaN: not invertible
};

}  // namespace gw::frontend

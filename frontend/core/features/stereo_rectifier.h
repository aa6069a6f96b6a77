// Turns one eye's image into that of the RectifiedCamera.
#pragma once

#include <cstdint>
#include <vector>

#include "common/camera/camera_model.h"
#include "frontend/core/features/image_buffer.h"

namespace gw::frontend {

enum class Eye { kLeft, kRight };

class StereoRectifier {
 public:
  StereoRectifier(const CameraGeometry& geometry, Eye eye);

  // Precondition: `source` is kGray8 of the calibrated size. Pixels without content are 0.
  void Rectify(const ImageView& source, ImageBuffer* rectified) const;

  // Per pixel of the rectified image: distance (px, larger of |dx|, |dy|) to the next pixel without
  // content, up to 255; the outside of the image counts as content.
  const ImageBuffer& valid() const { return valid_; }

 private:
  int width_, height_;
  // Source of a rectified pixel: the upper left of its four neighbours, and how far the pixel lies
  // to the right of it and below, in 1/32 px. No pixel: all zero, and valid_ is 0 there.
  struct Source {
    uint16_t x, y;
    uint8_t right, below;
  };
  std::vector<Source> sources_;
  ImageBuffer valid_;
};

}  // namespace gw::frontend

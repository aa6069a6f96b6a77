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
  // Source of a rectified pixel: index of the upper left of its four neighbours (-1: none), and the
  // weights of the right and lower ones in 1/32 px, packed as (v << 8 | u).
  std::vector<int32_t> source_x_, source_y_;
  std::vector<uint16_t> fraction_;
  ImageBuffer valid_;
};

}  // namespace gw::frontend

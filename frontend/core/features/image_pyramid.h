// Image pyramid: level 0 is the image, each further level is smaller by the scale factor. Pixel
// centres have integer coordinates on every level; a pixel (x, y) of level l lies at
// ((x + 0.5) * width_0 / width_l - 0.5, ...) of level 0.
//
// Every level is smoothed once: level 0 with two 3x3 binomial filters (sigma 1 px), each further
// level is the one before, resized and filtered once; that settles at sigma 1.4 px of the level.
// Corners, orientations and descriptors are all taken from these smoothed levels. With corners from
// raw levels and descriptors from a 7x7 Gaussian of sigma 2, pairs of TUM fr1_rpy images had
// about a sixth fewer right matches (feature_study).
#pragma once

#include <vector>

#include "frontend/core/features/image_buffer.h"
#include "frontend/core/features/image_filter.h"

namespace gw::frontend {

class ImagePyramid {
 public:
  // Builds no level narrower or lower than `min_size` px, so there may be fewer than `num_levels`
  // (but always level 0). Preconditions: sizes > 0, num_levels >= 1, 1 < scale_factor <= 2.
  ImagePyramid(int width, int height, int num_levels, double scale_factor, int min_size);

  // Precondition: `image` is kGray8 and has the size given to the constructor.
  void Build(const ImageView& image);

  int num_levels() const { return static_cast<int>(levels_.size()); }
  const ImageBuffer& level(int l) const { return levels_[static_cast<size_t>(l)]; }
  int stride() const { return levels_[0].stride; }  // the same on all levels

  // Size of a pixel of level l in pixels of level 0, per axis (width and height round differently).
  float scale_x(int l) const {
    return static_cast<float>(levels_[0].width) /
           static_cast<float>(levels_[static_cast<size_t>(l)].width);
  }
  float scale_y(int l) const {
    return static_cast<float>(levels_[0].height) /
           static_cast<float>(levels_[static_cast<size_t>(l)].height);
  }

 private:
  std::vector<ImageBuffer> levels_;
  std::vector<BilinearResizer> resizers_;  // [l]: level l to l + 1
  BinomialFilter filter_;
  ImageBuffer scratch_;
};

}  // namespace gw::frontend

#include "frontend/core/features/image_pyramid.h"

#include <cmath>

#include "common/core/check.h"

namespace gw::frontend {

ImagePyramid::ImagePyramid(int width, int height, int num_levels, double scale_factor,
                           int min_size) {
  GW_CHECK(width > 0 && height > 0 && num_levels >= 1 && scale_factor > 1 && scale_factor <= 2);
  constexpr int kBlock = 16;
  const int stride = (width + kBlock - 1) / kBlock * kBlock + kBlock;
  for (int l = 0; l < num_levels; ++l) {
    const double scale = std::pow(scale_factor, l);
    const int level_width = static_cast<int>(std::ceil(width / scale));
    const int level_height = static_cast<int>(std::ceil(height / scale));
    if (l > 0 && (level_width < min_size || level_height < min_size)) break;
    if (l > 0) {
      resizers_.emplace_back(levels_.back().width, levels_.back().height, level_width,
                             level_height);
    }
    levels_.emplace_back().Resize(level_width, level_height, stride);
  }
  scratch_.Resize(width, height, stride);
}

void ImagePyramid::Build(const ImageView& image) {
  GW_CHECK(image.Is(PixelFormat::kGray8, levels_[0].width, levels_[0].height));
  filter_.Apply(image, &scratch_);
  filter_.Apply(scratch_.View(), &levels_[0]);
  for (size_t l = 1; l < levels_.size(); ++l) {
    scratch_.Resize(levels_[l].width, levels_[l].height, scratch_.stride);
    resizers_[l - 1].Apply(levels_[l - 1], &scratch_);
    filter_.Apply(scratch_.View(), &levels_[l]);
  }
}

}  // namespace gw::frontend

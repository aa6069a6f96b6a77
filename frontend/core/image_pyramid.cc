#include "frontend/core/image_pyramid.h"

#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "common/core/check.h"

namespace gw::frontend {
namespace {

cv::Mat AsMat(ImageBuffer& image) {
  return cv::Mat(image.height, image.width, CV_8UC1, image.pixels.data(),
                 static_cast<size_t>(image.stride));
}

}  // namespace

ImagePyramid::ImagePyramid(int width, int height, int num_levels, double scale_factor,
                           int min_size) {
  GW_CHECK(width > 0 && height > 0 && num_levels >= 1 && scale_factor > 1);
  const int stride = (width + 15) / 16 * 16;
  for (int l = 0; l < num_levels; ++l) {
    const double scale = std::pow(scale_factor, l);
    const int level_width = static_cast<int>(std::lround(width / scale));
    const int level_height = static_cast<int>(std::lround(height / scale));
    if (l > 0 && (level_width < min_size || level_height < min_size)) break;
    levels_.emplace_back().Resize(level_width, level_height, stride);
    smooth_.emplace_back().Resize(level_width, level_height, stride);
  }
}

void ImagePyramid::Build(const ImageView& image) {
  GW_CHECK(image.format == PixelFormat::kGray8 && image.width == levels_[0].width &&
           image.height == levels_[0].height);
  for (int y = 0; y < image.height; ++y) {
    std::memcpy(levels_[0].row(y), image.data + static_cast<ptrdiff_t>(y) * image.stride,
                static_cast<size_t>(image.width));
  }
  for (size_t l = 0; l < levels_.size(); ++l) {
    cv::Mat level = AsMat(levels_[l]);
    if (l > 0) {
      cv::resize(AsMat(levels_[l - 1]), level, level.size(), 0, 0, cv::INTER_LINEAR);
    }
    cv::Mat smooth = AsMat(smooth_[l]);
    cv::GaussianBlur(level, smooth, cv::Size(7, 7), 2, 2, cv::BORDER_REFLECT_101);
  }
}

}  // namespace gw::frontend

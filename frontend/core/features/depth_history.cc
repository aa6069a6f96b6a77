#include "frontend/core/features/depth_history.h"

#include <cstring>
#include <utility>

namespace gw::frontend {

void DepthHistory::Push(const ImageView& depth) {
  std::swap(images_[0], images_[1]);
  Image& to = images_[0];
  const int row_bytes = depth.width * BytesPerPixel(depth.format);
  const auto row = static_cast<size_t>(row_bytes);
  const auto height = static_cast<size_t>(depth.height);
  to.rows.resize(row * height);
  for (size_t y = 0; y < height; ++y) {
    std::memcpy(&to.rows[y * row], depth.data + y * static_cast<size_t>(depth.stride), row);
  }
  to.view = {to.rows.data(), depth.width, depth.height, row_bytes, depth.format};
}

void DepthHistory::Clear() {
  for (Image& image : images_) image.view = {};
}

}  // namespace gw::frontend

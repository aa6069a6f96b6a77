// A grey image that we own. Rows may be wider than the image, so that the levels of a pyramid can
// share one stride (pixel offsets of a sampling pattern are then the same on every level).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/core/image_view.h"

namespace gw::frontend {

struct ImageBuffer {
  // Bytes that may be read (but mean nothing) behind the last row: vector code loads whole blocks.
  static constexpr size_t kSlack = 64;

  int width = 0;
  int height = 0;
  int stride = 0;  // bytes from one row to the next, >= width
  std::vector<uint8_t> pixels;

  // Content is undefined afterwards. Keeps the memory when it is large enough.
  void Resize(int new_width, int new_height, int new_stride) {
    width = new_width;
    height = new_height;
    stride = new_stride;
    pixels.resize(static_cast<size_t>(stride) * static_cast<size_t>(height) + kSlack);
  }
  const uint8_t* row(int y) const {
    return pixels.data() + static_cast<size_t>(y) * static_cast<size_t>(stride);
  }
  uint8_t* row(int y) {
    return pixels.data() + static_cast<size_t>(y) * static_cast<size_t>(stride);
  }
  ImageView View() const { return {pixels.data(), width, height, stride, PixelFormat::kGray8}; }
};

}  // namespace gw::frontend

// A look at pixels that someone else owns. Valid only while the owner lives.
#pragma once

#include <cstdint>

namespace gw {

enum class PixelFormat : int32_t {
  kNone = 0,
  kGray8 = 1,  // one byte a pixel
  kDepth16 =
      2  // little-endian uint16 a pixel, in units of the calibration's depth_unit_m; 0 = no depth
};

constexpr int BytesPerPixel(PixelFormat format) {
  return format == PixelFormat::kGray8 ? 1 : format == PixelFormat::kDepth16 ? 2 : 0;
}

struct ImageView {
  const uint8_t* data = nullptr;
  int width = 0;
  int height = 0;
  int stride = 0;  // bytes from one row to the next, >= width * BytesPerPixel(format)
  PixelFormat format = PixelFormat::kNone;

  bool empty() const { return data == nullptr; }
  // There are pixels, and they are of this kind and size.
  bool Is(PixelFormat of_format, int of_width, int of_height) const {
    return data != nullptr && format == of_format && width == of_width && height == of_height &&
           stride >= width * BytesPerPixel(format);
  }
};

}  // namespace gw

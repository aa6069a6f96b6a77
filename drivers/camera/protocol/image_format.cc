#include "drivers/camera/protocol/image_format.h"

#include <algorithm>

#include "common/core/check.h"

namespace gw::camera {

std::string FourccName(uint32_t fourcc) {
  std::string name;
  for (int shift = 0; shift < 32; shift += 8) {
    const char c = static_cast<char>(fourcc >> shift & 0x7F);
    name += c >= ' ' && c <= '~' ? c : '?';
  }
  return name;
}

size_t ImageBytes(uint32_t fourcc, int width, int height) {
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  switch (fourcc) {
    case kGrey:
      return pixels;
    case kY8i:
    case kZ16:
    case kYuyv:
      return 2 * pixels;
    default:
      return 0;
  }
}

void SplitY8i(std::span<const uint8_t> y8i, std::span<uint8_t> left, std::span<uint8_t> right) {
  GW_CHECK(y8i.size() == 2 * left.size() && left.size() == right.size());
  for (size_t i = 0; i < left.size(); ++i) {
    left[i] = y8i[2 * i];
    right[i] = y8i[2 * i + 1];
  }
}

void YuyvToGrey(std::span<const uint8_t> yuyv, std::span<uint8_t> grey) {
  GW_CHECK(yuyv.size() == 2 * grey.size());
  for (size_t i = 0; i < grey.size(); ++i) grey[i] = yuyv[2 * i];
}

void SplitSideBySide(std::span<const uint8_t> both, int width, std::span<uint8_t> left,
                     std::span<uint8_t> right) {
  GW_CHECK(width > 0 && width % 2 == 0 && both.size() % static_cast<size_t>(width) == 0);
  GW_CHECK(both.size() == 2 * left.size() && left.size() == right.size());
  const auto half = static_cast<size_t>(width) / 2;
  for (size_t out = 0; out < left.size(); out += half) {
    std::copy_n(both.data() + 2 * out, half, left.data() + out);
    std::copy_n(both.data() + 2 * out + half, half, right.data() + out);
  }
}

}  // namespace gw::camera

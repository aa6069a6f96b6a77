// The pixel formats of V4L2 that the driver takes, and how they become ours (grey, depth). Names
// and layouts: Linux kernel documentation, "Image Formats"; fourcc values are those of videodev2.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace gw::camera {

constexpr uint32_t Fourcc(char a, char b, char c, char d) {
  return static_cast<uint32_t>(static_cast<uint8_t>(a)) |
         static_cast<uint32_t>(static_cast<uint8_t>(b)) << 8 |
         static_cast<uint32_t>(static_cast<uint8_t>(c)) << 16 |
         static_cast<uint32_t>(static_cast<uint8_t>(d)) << 24;
}

inline constexpr uint32_t kGrey = Fourcc('G', 'R', 'E', 'Y');  // one byte for each pixel
// A left and a right byte for each pixel.
inline constexpr uint32_t kY8i = Fourcc('Y', '8', 'I', ' ');
inline constexpr uint32_t kZ16 = Fourcc('Z', '1', '6', ' ');   // depth, little-endian uint16
inline constexpr uint32_t kYuyv = Fourcc('Y', 'U', 'Y', 'V');  // 4:2:2, every other byte is luma

// The name of a fourcc for messages, like "Z16 ".
std::string FourccName(uint32_t fourcc);

// The bytes of an image without row padding; 0 for a format that is not one of the four.
size_t ImageBytes(uint32_t fourcc, int width, int height);

// Splits a Y8I image into left and right. Precondition: both outputs are half as long as `y8i`.
void SplitY8i(std::span<const uint8_t> y8i, std::span<uint8_t> left, std::span<uint8_t> right);

// Takes the luma out of a YUYV image. Precondition: `grey` is half as long as `yuyv`.
void YuyvToGrey(std::span<const uint8_t> yuyv, std::span<uint8_t> grey);

// Splits a grey image that holds two eyes side by side. Precondition: the sizes fit, and the width
// is even.
void SplitSideBySide(std::span<const uint8_t> both, int width, std::span<uint8_t> left,
                     std::span<uint8_t> right);

}  // namespace gw::camera

// The calibration that a D4xx camera stores: rectified intrinsics by resolution and the baseline.
//
// Table 25 (depth coefficients): a header of 16 bytes {u16 big-endian version, u16 type, u32 bytes
// behind the header, u32, u32 CRC-32 of them, as zlib computes it}, the raw calibration of both
// imagers, the baseline in mm and {fx, fy, ppx, ppy} of the rectified images of 16 resolutions.
// Depth and the rectified infra-red images have no distortion, and the depth image is that of the
// left eye.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/core/result.h"

namespace gw::camera {

inline constexpr uint32_t kDepthTableId = 25;

struct PinholePx {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
};

struct DepthCalibration {
  double baseline_m = 0;  // the right eye lies so far to the right of the left one; > 0
  PinholePx camera;       // intrinsics that both rectified eyes have
};

// The calibration of the rectified images of width x height. Error kBadData: the table is too
// short, has a wrong CRC, or a baseline or focal length that cannot be. A resolution without an
// entry is scaled from 1920x1080.
Result<DepthCalibration> ParseDepthTable(std::span<const uint8_t> table, int width, int height);

// The intrinsics out of the answer to kRectified (newer firmware), which is {u16 width, u16 height,
// 4 x f32} again and again. Empty when the resolution is not in it.
std::optional<PinholePx> FindRectified(std::span<const uint8_t> answer, int width, int height);

}  // namespace gw::camera

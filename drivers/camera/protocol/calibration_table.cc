#include "drivers/camera/protocol/calibration_table.h"

#include <zlib.h>

#include <array>
#include <cmath>
#include <string>

#include "drivers/common/bytes.h"

namespace gw::camera {
namespace {

constexpr size_t kHeaderBytes = 16;
constexpr size_t kSizeAt = 4, kCrcAt = 12;
constexpr size_t kBaselineAt = 160;
constexpr size_t kRectifiedAt = 256;
constexpr size_t kEntryBytes = 16;

struct Resolution {
  int width, height;
};
// The resolutions by their index in the table; {0, 0} is reserved.
constexpr std::array<Resolution, 16> kResolutions{{{1920, 1080},
                                                   {1280, 720},
                                                   {640, 480},
                                                   {848, 480},
                                                   {640, 360},
                                                   {424, 240},
                                                   {320, 240},
                                                   {480, 270},
                                                   {1280, 800},
                                                   {960, 540},
                                                   {0, 0},
                                                   {0, 0},
                                                   {640, 400},
                                                   {576, 576},
                                                   {720, 720},
                                                   {1152, 1152}}};

PinholePx ReadPinhole(std::span<const uint8_t> bytes, size_t at) {
  return {ReadF32(bytes, at), ReadF32(bytes, at + 4), ReadF32(bytes, at + 8),
          ReadF32(bytes, at + 12)};
}

PinholePx ReadEntry(std::span<const uint8_t> table, size_t index) {
  return ReadPinhole(table, kRectifiedAt + index * kEntryBytes);
}

bool Plausible(const PinholePx& camera, int width, int height) {
  return std::isfinite(camera.fx) && std::isfinite(camera.fy) && camera.fx > 0.2 * width &&
         camera.fx < 10 * width && camera.fy > 0.2 * width && camera.fy < 10 * width &&
         camera.cx > 0 && camera.cx < width && camera.cy > 0 && camera.cy < height;
}

PinholePx CameraOf(std::span<const uint8_t> table, int width, int height) {
  // The mode 848x100 shows the rows cut out of the middle of 848x480.
  if (width == 848 && height == 100) {
    PinholePx camera = CameraOf(table, 848, 480);
    camera.cy -= 190;
    return camera;
  }
  for (size_t i = 0; i < kResolutions.size(); ++i) {
    if (kResolutions[i].width != width || kResolutions[i].height != height) continue;
    const PinholePx camera = ReadEntry(table, i);
    if (camera.fx == camera.fy && camera.cx == camera.cy) {  // the factory left a placeholder
      return {1.5 * width, 1.5 * width, width / 2., height / 2.};
    }
    return camera;
  }
  const PinholePx full = ReadEntry(table, 0);
  const double x = width / 1920., y = height / 1080.;
  return {full.fx * x, full.fy * y, full.cx * x, full.cy * y};
}

}  // namespace

Result<DepthCalibration> ParseDepthTable(std::span<const uint8_t> table, int width, int height) {
  const auto bad = [](const std::string& why) {
    return Error{ErrorCode::kBadData, "calibration table of the camera: " + why};
  };
  constexpr size_t kLeast = kRectifiedAt + kResolutions.size() * kEntryBytes;
  if (table.size() < kLeast) return bad(std::to_string(table.size()) + " bytes are too few");
  const uint32_t size = ReadU32(table, kSizeAt);
  if (size < kLeast - kHeaderBytes || size > table.size() - kHeaderBytes) {
    return bad("claims " + std::to_string(size) + " bytes");
  }
  if (crc32_z(0, table.data() + kHeaderBytes, size) != ReadU32(table, kCrcAt)) {
    return bad("wrong checksum; recalibrate the camera with its maker's tool");
  }
  DepthCalibration out;
  out.baseline_m = std::abs(ReadF32(table, kBaselineAt)) * 1e-3;
  if (!(out.baseline_m > 0.01 && out.baseline_m < 0.5)) {
    return bad("baseline of " + std::to_string(out.baseline_m) + " m");
  }
  out.camera = CameraOf(table, width, height);
  if (!Plausible(out.camera, width, height)) {
    return bad("no usable intrinsics for " + std::to_string(width) + "x" + std::to_string(height));
  }
  return out;
}

std::optional<PinholePx> FindRectified(std::span<const uint8_t> answer, int width, int height) {
  constexpr size_t kRecordBytes = 20;
  for (size_t at = 0; at + kRecordBytes <= answer.size(); at += kRecordBytes) {
    if (ReadU16(answer, at) != width || ReadU16(answer, at + 2) != height) continue;
    const PinholePx camera = ReadPinhole(answer, at + 4);
    if (Plausible(camera, width, height)) return camera;
  }
  return std::nullopt;
}

}  // namespace gw::camera

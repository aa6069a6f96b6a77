#include "test/emulators/camera/camera_peer.h"

#include <zlib.h>

#include <algorithm>

#include "common/core/check.h"
#include "drivers/common/bytes.h"

namespace gw::camera {
namespace {

void Put(std::vector<uint8_t>* bytes, size_t at, const std::vector<uint8_t>& value) {
  std::copy(value.begin(), value.end(), bytes->begin() + static_cast<ptrdiff_t>(at));
}
void PutU32(std::vector<uint8_t>* bytes, size_t at, uint32_t value) {
  std::vector<uint8_t> text;
  AppendU32(value, &text);
  Put(bytes, at, text);
}
void PutF32(std::vector<uint8_t>* bytes, size_t at, double value) {
  std::vector<uint8_t> text;
  AppendF32(static_cast<float>(value), &text);
  Put(bytes, at, text);
}
void PutPinhole(std::vector<uint8_t>* bytes, size_t at, const PinholePx& camera) {
  PutF32(bytes, at, camera.fx);
  PutF32(bytes, at + 4, camera.fy);
  PutF32(bytes, at + 8, camera.cx);
  PutF32(bytes, at + 12, camera.cy);
}

std::vector<uint8_t> Block(uint32_t id, size_t size) {
  std::vector<uint8_t> block(size);
  PutU32(&block, 0, id);
  PutU32(&block, 4, static_cast<uint32_t>(size));
  PutU32(&block, 8, 2);
  return block;
}

// Sets a field of a block and the flag that announces it.
void PutField(std::vector<uint8_t>* block, uint32_t flag, size_t at,
              const std::optional<uint32_t>& value) {
  if (!value) return;
  PutU32(block, 12, ReadU32(*block, 12) | flag);
  PutU32(block, at, *value);
}

std::vector<uint8_t> FromHex(const std::string& hex) {
  std::vector<uint8_t> out;
  for (size_t i = 0; i + 1 < hex.size(); i += 2) {
    out.push_back(static_cast<uint8_t>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  }
  return out;
}

}  // namespace

std::vector<uint8_t> EncodeMetadata(const FrameMetadata& metadata, bool d4xx) {
  std::vector<uint8_t> out;
  AppendU64(static_cast<uint64_t>(metadata.host_ns), &out);
  AppendU16(0x123, &out);
  out.push_back(232);
  out.push_back(metadata.pts_us ? 0x8E : 0x8A);
  AppendU32(metadata.pts_us.value_or(0), &out);
  AppendU32(0x55AA55AA, &out);  // the SCR
  AppendU16(0x124, &out);
  if (!d4xx) return out;

  std::vector<uint8_t> timing = Block(0x80000001, 40);
  PutField(&timing, 0x01, 16, metadata.frame_counter);
  PutField(&timing, 0x02, 20, metadata.to_mid_exposure_us);
  PutField(&timing, 0x08, 28, metadata.exposure_us);
  std::vector<uint8_t> control = Block(0x80000000, 60);
  PutField(&control, 0x01, 16, metadata.gain);
  PutField(&control, 0x02, 20, metadata.exposure_us);
  PutField(&control, 0x04, 24, metadata.laser_power_mw);
  if (metadata.emitter_on) {
    PutU32(&control, 12, ReadU32(control, 12) | 0x80);
    control[56] = *metadata.emitter_on ? 1 : 0;
  }
  for (const auto& block : {timing, Block(3, 80), control, Block(0x80000002, 40)}) {
    out.insert(out.end(), block.begin(), block.end());
  }
  GW_CHECK(out.size() == 10 + 232);
  return out;
}

std::vector<uint8_t> EncodeDepthTable(const StoredCalibration& calibration) {
  std::vector<uint8_t> out(512);
  out[0] = 2;  // version 2.0, big-endian
  out[2] = 25;
  PutU32(&out, 4, 512 - 16);
  PutF32(&out, 160, calibration.baseline_mm);
  for (size_t i = 0; i < 16; ++i) PutPinhole(&out, 256 + 16 * i, {100, 100, 100, 100});
  PutPinhole(&out, 256, calibration.full_hd);
  PutPinhole(&out, 256 + 2 * 16, calibration.vga);
  PutU32(&out, 12, static_cast<uint32_t>(crc32_z(0, out.data() + 16, out.size() - 16)));
  return out;
}

std::vector<uint8_t> EncodeAnswer(int32_t echo, std::span<const uint8_t> payload) {
  std::vector<uint8_t> out(kMonitorBytes);
  PutU32(&out, 0, static_cast<uint32_t>(echo));
  std::copy(payload.begin(), payload.end(), out.begin() + 4);
  PutU32(&out, kMonitorBytes - 4, static_cast<uint32_t>(payload.size()));
  return out;
}

std::vector<uint8_t> EncodeVersion(const FirmwareVersion& firmware,
                                   const std::string& asic_serial) {
  std::vector<uint8_t> out(256);
  Put(&out, 12, {firmware.build, firmware.patch, firmware.minor, firmware.major});
  Put(&out, 48, {0x01, 0x23, 0x45, 0x67, 0x89, 0xAB});
  const std::vector<uint8_t> serial = FromHex(asic_serial);
  GW_CHECK(serial.size() <= 6);
  Put(&out, 64, serial);
  return out;
}

}  // namespace gw::camera

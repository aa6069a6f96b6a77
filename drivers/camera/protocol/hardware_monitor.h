// The hardware monitor of D4xx cameras: requests and answers of 1024 bytes through selector 1 of
// the depth extension unit. Only what the driver uses.
//
// Request: u16 bytes that follow the first four, u16 0xCDAB, u32 opcode, 4 x u32 parameter, data.
// Answer: the opcode again or a negative error, the payload, and its length in the last four bytes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/core/result.h"

namespace gw::camera {

inline constexpr size_t kMonitorBytes = 1024;

enum class Opcode : uint32_t {
  kVersion = 0x10,           // tells firmware, serial numbers, chips
  kCalibrationTable = 0x15,  // parameter 1 is the id of the table
  kSubPreset = 0x7B,         // parameter 1 is the length of the data; without data back to normal
  kRectified = 0x7E,         // tells intrinsics by resolution
};

struct MonitorRequest {
  Opcode opcode = Opcode::kVersion;
  std::array<uint32_t, 4> parameters{};
  std::vector<uint8_t> data{};  // at most kMonitorBytes - 24 bytes
};

// The 1024 bytes that have to be written for a request.
std::vector<uint8_t> EncodeRequest(const MonitorRequest& request);
// The payload of an answer to `opcode`. Error kBadData: an error code of the camera (with its
// meaning), the answer of another request, or an impossible length.
Result<std::vector<uint8_t>> DecodeAnswer(std::span<const uint8_t> answer, Opcode opcode);

MonitorRequest VersionRequest();
MonitorRequest CalibrationRequest(uint32_t table_id);
// The request that switches the projector on in every other frame, or ends that. Firmware
// 5.12.8.100 or newer.
MonitorRequest AlternatingEmitterRequest(bool alternate);

struct FirmwareVersion {
  uint8_t major = 0, minor = 0, patch = 0, build = 0;
  auto operator<=>(const FirmwareVersion&) const = default;
  std::string text() const;
};

struct CameraVersion {
  FirmwareVersion firmware;
  std::string module_serial;  // printed on the camera
  std::string asic_serial;    // what USB shows
};
// Reads the payload of kVersion. Error kBadData: it is too short.
Result<CameraVersion> ParseVersion(std::span<const uint8_t> payload);

}  // namespace gw::camera

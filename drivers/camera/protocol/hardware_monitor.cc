#include "drivers/camera/protocol/hardware_monitor.h"

#include <algorithm>

#include "common/core/check.h"
#include "drivers/common/bytes.h"

namespace gw::camera {
namespace {

constexpr uint16_t kMagic = 0xCDAB;
constexpr size_t kRequestHeaderBytes = 24;

// Offsets in the payload of kVersion.
constexpr size_t kFirmwareAt = 12;
constexpr size_t kModuleSerialAt = 48;
constexpr size_t kAsicSerialAt = 64;
constexpr size_t kSerialBytes = 6;

const char* Meaning(int32_t error) {
  switch (error) {
    case -1:
      return "wrong command";
    case -6:
      return "wrong parameter";
    case -7:
      return "not ready";
    case -21:
      return "no data";
    case -25:
      return "table is empty";
    default:
      return "unknown error";
  }
}

std::string Hex(std::span<const uint8_t> bytes) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string out;
  for (const uint8_t byte : bytes) {
    out += kDigits[byte >> 4];
    out += kDigits[byte & 15];
  }
  return out;
}

}  // namespace

std::vector<uint8_t> EncodeRequest(const MonitorRequest& request) {
  GW_CHECK(request.data.size() <= kMonitorBytes - kRequestHeaderBytes);
  std::vector<uint8_t> out;
  AppendU16(static_cast<uint16_t>(kRequestHeaderBytes - 4 + request.data.size()), &out);
  AppendU16(kMagic, &out);
  AppendU32(static_cast<uint32_t>(request.opcode), &out);
  for (const uint32_t parameter : request.parameters) AppendU32(parameter, &out);
  out.insert(out.end(), request.data.begin(), request.data.end());
  out.resize(kMonitorBytes);
  return out;
}

Result<std::vector<uint8_t>> DecodeAnswer(std::span<const uint8_t> answer, Opcode opcode) {
  if (answer.size() != kMonitorBytes) {
    return Error{ErrorCode::kBadData,
                 "hardware monitor answered " + std::to_string(answer.size()) + " bytes"};
  }
  const int32_t echo = ReadI32(answer, 0);
  if (echo < 0) {
    return Error{ErrorCode::kBadData,
                 "hardware monitor: error " + std::to_string(echo) + " (" + Meaning(echo) + ")"};
  }
  if (static_cast<uint32_t>(echo) != static_cast<uint32_t>(opcode)) {
    return Error{ErrorCode::kBadData, "hardware monitor answered another request"};
  }
  const uint32_t length = ReadU32(answer, kMonitorBytes - 4);
  if (length > kMonitorBytes - 8) {
    return Error{ErrorCode::kBadData,
                 "hardware monitor claims " + std::to_string(length) + " bytes of payload"};
  }
  return std::vector<uint8_t>(answer.begin() + 4, answer.begin() + 4 + length);
}

MonitorRequest VersionRequest() {
  return {.opcode = Opcode::kVersion};
}

MonitorRequest CalibrationRequest(uint32_t table_id) {
  return {.opcode = Opcode::kCalibrationTable, .parameters = {table_id}};
}

MonitorRequest AlternatingEmitterRequest(bool alternate) {
  MonitorRequest request{.opcode = Opcode::kSubPreset};
  if (alternate) {
    // This is sequence 0x0F of two items of one frame each: laser off, laser on.
    request.data = {0x05, 0x0F, 0, 0, 2, 4, 1, 0, 1, 0, 0, 0, 0, 0, 4, 1, 0, 1, 0, 1, 0, 0, 0};
  }
  request.parameters[0] = static_cast<uint32_t>(request.data.size());
  return request;
}

std::string FirmwareVersion::text() const {
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch) + "." +
         std::to_string(build);
}

Result<CameraVersion> ParseVersion(std::span<const uint8_t> payload) {
  if (payload.size() < kAsicSerialAt + kSerialBytes) {
    return Error{ErrorCode::kBadData,
                 "version block of " + std::to_string(payload.size()) + " bytes"};
  }
  CameraVersion out;
  out.firmware = {payload[kFirmwareAt + 3], payload[kFirmwareAt + 2], payload[kFirmwareAt + 1],
                  payload[kFirmwareAt]};
  out.module_serial = Hex(payload.subspan(kModuleSerialAt, kSerialBytes));
  out.asic_serial = Hex(payload.subspan(kAsicSerialAt, kSerialBytes));
  return out;
}

}  // namespace gw::camera

#include "drivers/camera/protocol/depth_unit_controls.h"

#include <algorithm>

#include "drivers/common/bytes.h"

namespace gw::camera {

UnitControl SetEmitter(bool on) {
  return {Selector::kEmitter, {static_cast<uint8_t>(on ? 1 : 0)}};
}

UnitControl SetAutoExposure(bool on) {
  return {Selector::kAutoExposure, {static_cast<uint8_t>(on ? 1 : 0)}};
}

UnitControl SetExposureUs(uint32_t us) {
  UnitControl control{Selector::kExposure, {}};
  AppendU32(us, &control.value);
  return control;
}

UnitControl SetLaserPowerMw(uint16_t mw) {
  UnitControl control{Selector::kLaserPower, {}};
  AppendU16(mw, &control.value);
  return control;
}

std::optional<Temperatures> ParseTemperatures(std::span<const uint8_t> value) {
  if (value.size() != 4) return std::nullopt;
  Temperatures out;
  if (value[0] != 0) out.projector_c = static_cast<int8_t>(value[2]);
  if (value[1] != 0) out.asic_c = static_cast<int8_t>(value[3]);
  return out;
}

std::string DeviceErrorText(uint8_t code) {
  switch (code) {
    case 0:
      return "";
    case 1:
      return "projector too hot, power reduced";
    case 2:
      return "projector too hot, switched off";
    case 4:
      return "stereo module not connected";
    case 5:
      return "memory of the camera damaged";
    case 6:
      return "calibration of the camera damaged";
    case 10:
      return "motion module failed";
    case 11:
    case 12:
    case 13:
      return "data overflow: the computer does not keep up or the cable is bad";
    case 26:
      return "too much for a USB 2 link";
    default:
      return "error " + std::to_string(code);
  }
}

uint32_t ClampToSteps(uint32_t wanted, uint32_t min, uint32_t max, uint32_t step) {
  const uint32_t clamped = std::clamp(wanted, min, max);
  return min + (clamped - min) / std::max(step, 1U) * std::max(step, 1U);
}

}  // namespace gw::camera

// Controls of the depth extension unit of D4xx cameras (UVC unit 3, GUID
// C9606CCB-594C-4D25-AF47-CCC496435995) as bytes to be set, little-endian.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace gw::camera {

inline constexpr uint8_t kDepthUnit = 3;

enum class Selector : uint8_t {
  kMonitor = 1,        // requests and answers of hardware_monitor.h
  kEmitter = 2,        // u8: 0 off, 1 laser
  kExposure = 3,       // u32, us; used when automatic exposure is off
  kLaserPower = 4,     // u16, mW; used when the emitter is on
  kErrors = 7,         // u8
  kTemperature = 9,    // told while streaming
  kAutoExposure = 11,  // u8
};

struct UnitControl {
  Selector selector = Selector::kEmitter;
  std::vector<uint8_t> value;
  bool operator==(const UnitControl&) const = default;
};

UnitControl SetEmitter(bool on);
UnitControl SetAutoExposure(bool on);
UnitControl SetExposureUs(uint32_t us);
UnitControl SetLaserPowerMw(uint16_t mw);

struct Temperatures {
  std::optional<int> projector_c, asic_c;
};
// The temperatures that the four bytes of the selector tell; empty when there are not four.
std::optional<Temperatures> ParseTemperatures(std::span<const uint8_t> value);

// The meaning of a value of kErrors, for people; empty when it is no error.
std::string DeviceErrorText(uint8_t code);

// The value that the camera can do and that is nearest below the wanted one: within [min, max], a
// whole number of steps above min. Precondition: min <= max; a step of 0 counts as 1.
uint32_t ClampToSteps(uint32_t wanted, uint32_t min, uint32_t max, uint32_t step);

}  // namespace gw::camera

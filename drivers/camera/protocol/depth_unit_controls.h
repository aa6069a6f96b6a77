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
  kMonitor = 1,        // hardware_monitor.h
  kEmitter = 2,        // u8 0 off, 1 laser
  kExposure = 3,       // u32 us; when auto exposure is off
  kLaserPower = 4,     // u16 mW; when the emitter is on
  kErrors = 7,         // u8
  kTemperature = 9,    // while streaming
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
// What the selector's four bytes say; empty when there are not four.
std::optional<Temperatures> ParseTemperatures(std::span<const uint8_t> value);

// Of the value of kErrors, for people; empty when it is none.
std::string DeviceErrorText(uint8_t code);

// Brings a wish into what the camera can do: within [min, max], a whole number of steps above min.
// Precondition: min <= max; step 0 counts as 1.
uint32_t ClampToSteps(uint32_t wanted, uint32_t min, uint32_t max, uint32_t step);

}  // namespace gw::camera

// Battery and charger of the base: 4 cells of lithium-ion, 16.7 V full.
#pragma once

#include <algorithm>
#include <cstdint>

namespace gw::kobuki {

enum class Charging { kNo, kCharging, kFull };

struct BatteryState {
  double volts = 0;
  double percent = 0;
  Charging charging = Charging::kNo;
  // Charges from the adapter, not from the dock; meaningless when not charging.
  bool from_adapter = false;
  bool low = false;       // below 14.0 V: time to drive to the charger
  bool critical = false;  // below 13.2 V: the base will switch off within minutes
};

// The charge is taken as linear between 13.2 V (5 %) and 16.5 V (100 %), as in the Battery class of
// the published implementation (kobuki_core).
inline BatteryState ReadBattery(uint8_t battery_dv, uint8_t charger) {
  BatteryState out;
  out.volts = battery_dv * 0.1;
  out.percent = std::clamp(5 + (out.volts - 13.2) * (95 / 3.3), 0.0, 100.0);
  const int state = charger & 0x0F;
  out.charging = state == 6 ? Charging::kCharging : state == 2 ? Charging::kFull : Charging::kNo;
  out.from_adapter = (charger & 0x10) != 0;
  const bool plugged = out.charging != Charging::kNo;
  out.low = !plugged && battery_dv < 140;
  out.critical = !plugged && battery_dv < 132;
  return out;
}

}  // namespace gw::kobuki

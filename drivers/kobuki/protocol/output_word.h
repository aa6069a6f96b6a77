// The general-purpose outputs of the Kobuki: power supplies, LEDs, open-drain outputs. The wire
// carries all of them in one word, so that telling a LED without remembering the supplies would cut
// the power of the camera or of this computer.
#pragma once

#include <cstdint>

namespace gw::kobuki {

enum class Led { kLed1, kLed2 };
enum class LedColour : uint16_t { kOff = 0, kRed = 1, kGreen = 2, kOrange = 3 };

enum class Supply : uint16_t {
  k3V3 = 0x0010,
  k5V = 0x0020,
  k12V5A = 0x0040,
  k12V1A5 = 0x0080,
};

class OutputWord {
 public:
  // The state after power-on: all supplies on, LEDs and outputs off.
  OutputWord() = default;

  void Set(Led led, LedColour colour) {
    const int shift = led == Led::kLed1 ? 8 : 10;
    value_ =
        static_cast<uint16_t>((value_ & ~(3u << shift)) | static_cast<unsigned>(colour) << shift);
  }
  void Set(Supply supply, bool on) {
    const auto bit = static_cast<uint16_t>(supply);
    value_ = static_cast<uint16_t>(on ? value_ | bit : value_ & ~bit);
  }
  // Sets digital output 0..3. Precondition: 0 <= index < 4.
  void SetDigital(int index, bool on) {
    const unsigned bit = 1u << index;
    value_ = static_cast<uint16_t>(on ? value_ | bit : value_ & ~bit);
  }
  uint16_t value() const { return value_; }
  bool operator==(const OutputWord&) const = default;

 private:
  uint16_t value_ = 0x00F0;
};

}  // namespace gw::kobuki

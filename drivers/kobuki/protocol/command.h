// The commands that the host can give to the Kobuki. There is no answer to a command; a wrong one
// is ignored.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/kobuki/protocol/base_control.h"

namespace gw::kobuki {

enum class CommandId : uint8_t {
  kBaseControl = 1,
  kSound = 3,
  kSoundSequence = 4,
  kRequestExtra = 9,
  kOutput = 12,
  kSetGains = 13,
  kGetGains = 14,
};

enum class SoundSequence : uint8_t {
  kOn = 0,
  kOff = 1,
  kRecharge = 2,
  kButton = 3,
  kError = 4,
  kCleaningStart = 5,
  kCleaningEnd = 6,
};

// The flags of RequestExtra().
inline constexpr uint16_t kRequestHardwareVersion = 0x01;
inline constexpr uint16_t kRequestFirmwareVersion = 0x02;
inline constexpr uint16_t kRequestUdid = 0x08;
inline constexpr uint16_t kRequestIdentity =
    kRequestHardwareVersion | kRequestFirmwareVersion | kRequestUdid;

// PID gains of the wheel controller (firmware 1.2.0 and later), times 1000.
struct Gains {
  bool user = false;  // false means the factory gains; the numbers are then ignored
  uint32_t p_milli = 100000, i_milli = 100, d_milli = 2000;
};

// The protocol's number of a tone of this frequency, Hz; 0 is silence. A4, 440 Hz, is 826.
uint16_t SoundNote(double frequency_hz);

// Builds one frame of one or more commands, each at most once or twice: it must stay within 255
// bytes of payload.
class CommandFrame {
 public:
  CommandFrame& Drive(BaseControl control);
  CommandFrame& Sound(uint16_t note, uint8_t duration_ms);
  CommandFrame& Play(SoundSequence sequence);
  CommandFrame& RequestExtra(uint16_t flags);
  // Adds the whole output word; it is built with OutputWord, which remembers the supplies.
  CommandFrame& Output(uint16_t word);
  CommandFrame& SetGains(const Gains& gains);
  CommandFrame& GetGains();

  bool empty() const { return payload_.empty(); }
  // Precondition: !empty().
  std::vector<uint8_t> Encode() const;

 private:
  void Begin(CommandId id, uint8_t length);

  std::vector<uint8_t> payload_;
};

}  // namespace gw::kobuki

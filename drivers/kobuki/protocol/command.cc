#include "drivers/kobuki/protocol/command.h"

#include <algorithm>
#include <cmath>

#include "drivers/common/bytes.h"
#include "drivers/kobuki/protocol/frame.h"

namespace gw::kobuki {

uint16_t SoundNote(double frequency_hz) {
  if (!(frequency_hz > 0)) return 0;
  constexpr double kUnitS = 0.00000275;
  return static_cast<uint16_t>(std::clamp(std::round(1 / (frequency_hz * kUnitS)), 0.0, 65535.0));
}

void CommandFrame::Begin(CommandId id, uint8_t length) {
  payload_.push_back(static_cast<uint8_t>(id));
  payload_.push_back(length);
}

CommandFrame& CommandFrame::Drive(BaseControl control) {
  Begin(CommandId::kBaseControl, 4);
  AppendI16(control.speed_mm_s, &payload_);
  AppendI16(control.radius_mm, &payload_);
  return *this;
}

CommandFrame& CommandFrame::Sound(uint16_t note, uint8_t duration_ms) {
  Begin(CommandId::kSound, 3);
  AppendU16(note, &payload_);
  payload_.push_back(duration_ms);
  return *this;
}

CommandFrame& CommandFrame::Play(SoundSequence sequence) {
  Begin(CommandId::kSoundSequence, 1);
  payload_.push_back(static_cast<uint8_t>(sequence));
  return *this;
}

CommandFrame& CommandFrame::RequestExtra(uint16_t flags) {
  Begin(CommandId::kRequestExtra, 2);
  AppendU16(flags, &payload_);
  return *this;
}

CommandFrame& CommandFrame::Output(uint16_t word) {
  Begin(CommandId::kOutput, 2);
  AppendU16(word, &payload_);
  return *this;
}

CommandFrame& CommandFrame::SetGains(const Gains& gains) {
  Begin(CommandId::kSetGains, 13);
  payload_.push_back(gains.user ? 1 : 0);
  AppendU32(gains.p_milli, &payload_);
  AppendU32(gains.i_milli, &payload_);
  AppendU32(gains.d_milli, &payload_);
  return *this;
}

CommandFrame& CommandFrame::GetGains() {
  Begin(CommandId::kGetGains, 1);
  payload_.push_back(0);
  return *this;
}

std::vector<uint8_t> CommandFrame::Encode() const {
  return EncodeFrame(payload_);
}

}  // namespace gw::kobuki

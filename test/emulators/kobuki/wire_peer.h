// The robot's end of the Kobuki protocol: encodes feedback, decodes commands. The driver has the
// other halves; the property tests hold the two against each other.
#pragma once

#include <optional>
#include <vector>

#include "drivers/kobuki/protocol/base_control.h"
#include "drivers/kobuki/protocol/command.h"
#include "drivers/kobuki/protocol/feedback.h"

namespace gw::kobuki {

enum class VersionForm { kFourBytes, kTwoBytes };

// The payload of a frame with every part that is present, in the order of a real robot.
// Precondition: raw_gyro has 1 to kMaxGyroSamples samples; versions of the two-byte form have parts
// below 10.
std::vector<uint8_t> EncodeFeedback(const Feedback& feedback,
                                    VersionForm form = VersionForm::kFourBytes);

struct SoundCommand {
  uint16_t note = 0;
  uint8_t duration_ms = 0;
  bool operator==(const SoundCommand&) const = default;
};

// The commands of one frame; what it did not hold is absent.
struct Commands {
  std::optional<BaseControl> drive;
  std::optional<SoundCommand> sound;
  std::optional<uint8_t> sound_sequence;
  std::optional<uint16_t> request;
  std::optional<uint16_t> output;
  std::optional<ControllerInfo> set_gains;
  bool get_gains = false;
  bool operator==(const Commands&) const = default;
};

// Reads commands as the firmware does: what it does not understand it ignores.
Commands DecodeCommands(const std::vector<uint8_t>& payload);

}  // namespace gw::kobuki

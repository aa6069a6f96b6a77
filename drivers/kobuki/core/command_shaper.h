// Makes of BASE_COMMAND messages what the base is told: takes the newest command, its age, and the
// limits of speed and acceleration into account.
#pragma once

#include <optional>

#include "common/config/kobuki_config.h"
#include "common/contract/samples.h"
#include "drivers/kobuki/protocol/base_control.h"

namespace gw::kobuki {

class CommandShaper {
 public:
  explicit CommandShaper(const KobukiConfig& config) : config_(config) {}

  // Takes a command. False, and the command is ignored, when its numbers are not finite, or when it
  // was decided longer than the timeout before or after `now`, as when a recording is played beside
  // the robot.
  bool Push(const BaseCommand& command, Utime now);

  // What the sender wants now, within the speed limits; a stop when its last command is too old.
  Twist Wanted(Utime now) const;
  bool commanded(Utime now) const;

  // One step of the ramp toward `target`. Times must not decrease. A stop takes the deceleration
  // limit: 0.5 s and 0.2 m from 0.5 m/s at 0.6 m/s^2.
  Twist Step(const Twist& target, Utime now);
  // Stops at once, without ramp.
  void Halt() { current_ = {}; }

 private:
  KobukiConfig config_;
  BaseCommand command_;
  std::optional<Utime> received_;
  std::optional<Utime> stepped_;
  Twist current_;
};

}  // namespace gw::kobuki

// Stops the base when bumper, cliff sensor or wheel drop say so; firmware since 1.1.2 does not do
// it by itself (yujinrobot kobuki_driver documentation).
//
//   bumper or cliff   Every command with forward speed becomes a stop; backing off and turning in
//                     place pass. The block ends when the sensor has been clear for 0.5 s and the
//                     sender has commanded something without forward speed since the contact, which
//                     shows that it noticed.
//   wheel drop        Nothing passes, since someone holds the base. The block ends when both wheels
//                     have carried it for 1 s and the sender has commanded a stop since (silence
//                     counts as a stop), so that a base that is put down does not drive off.
#pragma once

#include <optional>

#include "common/contract/samples.h"
#include "drivers/kobuki/protocol/base_control.h"

namespace gw::kobuki {

class SafetyGuard {
 public:
  enum class Stop { kNone, kBumper, kCliff, kWheelDrop };

  // Takes what the sensors say, from every frame. Times must not decrease over Sense() and
  // Filter().
  void Sense(const ContactFlags& contact, Utime now);

  // The part of a command that may be driven. A command either passes whole or becomes a stop.
  Twist Filter(const Twist& wanted, Utime now);

  // The gravest reason for which forward motion is blocked now.
  Stop stop() const;
  int64_t stops() const { return stops_; }  // how often a block began

  static constexpr DurationUs kClearForContact = Milliseconds(500);
  static constexpr DurationUs kClearForDrop = Milliseconds(1000);

 private:
  struct Block {
    bool blocked = false;
    bool acknowledged = false;
    bool active = false;
    Utime last_active;
  };
  void Sense(bool active, Utime now, Block* block);
  static void Release(bool acknowledges, DurationUs clear_for, Utime now, Block* block);

  Block bumper_;
  Block cliff_;
  Block drop_;
  int64_t stops_ = 0;
};

}  // namespace gw::kobuki

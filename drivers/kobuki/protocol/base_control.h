// The form in which the Kobuki takes a motion: the speed of the outer wheel and the radius of the
// turn. Source: Kobuki protocol, yujinrobot kobuki_driver documentation (the sub-payload "Base
// Control"), and its published implementation, kobuki_core 1.4; see drivers/kobuki/README.md.
#pragma once

#include <cstdint>

namespace gw::kobuki {

// `speed` is that of the outer wheel, mm/s. `radius` is from the centre of the turn to the robot's
// centre, mm, positive when the centre of the turn is on the left; 0 drives straight, 1 turns in
// place.
struct BaseControl {
  int16_t speed_mm_s = 0;
  int16_t radius_mm = 0;
  bool operator==(const BaseControl&) const = default;
};

struct Twist {
  double v_m_s = 0;    // forward is positive
  double w_rad_s = 0;  // counter-clockwise is positive
};

// The nearest command that the protocol can carry; a motion that is not finite becomes a stop.
// `track_m` is the distance of the wheels that the firmware assumes, 0.23 m.
BaseControl MakeBaseControl(const Twist& twist, double track_m);

// The motion that the firmware makes of a command.
Twist ToTwist(const BaseControl& control, double track_m);

}  // namespace gw::kobuki

// How the Kobuki wants its motion told: the speed of the outer wheel and the radius of the turn.
// Source: kobuki_core 1.4 and the protocol appendix.
#pragma once

#include <cstdint>

namespace gw::kobuki {

// speed: of the outer wheel, mm/s. radius: from the centre of the turn to the robot's centre, mm,
// positive when the turn's centre is on the left; 0 drives straight, 1 turns in place.
struct BaseControl {
  int16_t speed_mm_s = 0;
  int16_t radius_mm = 0;
  bool operator==(const BaseControl&) const = default;
};

struct Twist {
  double v_m_s = 0;    // forward
  double w_rad_s = 0;  // counter-clockwise
};

// The nearest command that the wire can carry; what is not finite is a stop. `track_m`: distance of
// the wheels that the firmware assumes, 0.23.
BaseControl MakeBaseControl(const Twist& twist, double track_m);

// What the firmware makes of a command.
Twist ToTwist(const BaseControl& control, double track_m);

}  // namespace gw::kobuki

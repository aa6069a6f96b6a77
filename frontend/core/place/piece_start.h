// A robot that does not know where in the map it is maps on, in a piece of the map of its own: when
// is that begun? Not at once: most doubts pass (somebody walks by, a place is recognised a second
// later), and what stands before the lens of a robot that stands is no place. So the place has to
// be unknown for a while, and along a way (docs/adr/0047-pieces-of-a-map.md).
#pragma once

#include <optional>

#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw::frontend {

class PieceStart {
 public:
  static constexpr DurationUs kPatience = Milliseconds(3000);  // three times that of a place query
  static constexpr double kWay = 0.5;                          // m; or
  static constexpr double kTurn = 0.5;                         // rad

  // After every image. T_OC: its camera in the odometry frame; empty without dead reckoning, which
  // begins the wait anew. True: the place has been unknown long and far enough.
  bool Observe(Utime utime, bool place_known, const std::optional<SE3>& T_OC);

 private:
  struct Begin {
    Utime utime;
    SE3 T_OC;
  };
  std::optional<Begin> since_;
};

}  // namespace gw::frontend

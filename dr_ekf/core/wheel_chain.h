// The wheels' samples as one chain of intervals, so that no driven way is lost to a bad stamp.
//
// A base counts what its wheels turn and stamps it more or less well: samples come in bursts, with
// equal times, or a little before the one before. The way is driven all the same. What cannot
// stand alone waits and becomes a part of the next interval (docs/adr/0017-wheels-as-sums.md).
#pragma once

#include <optional>

#include "common/config/dr_ekf_config.h"
#include "common/contract/samples.h"
#include "common/core/time.h"

namespace gw::dr_ekf {

class WheelChain {
 public:
  // period: nominal, of the samples.
  WheelChain(const DrEkfConfig& config, DurationUs period) : config_(config), period_(period) {}

  enum class Fate {
    kReady,   // `interval` is to be used
    kWaits,   // joins the next sample
    kAbsurd,  // no such motion, whatever the stamps: lost
  };
  struct Link {
    Fate fate = Fate::kAbsurd;
    WheelSample interval;  // the sample, with those before it that waited
  };

  // The sample's times are those of measurement. A sample that does not go on where the newest one
  // ended (a loss, a late one) begins a new chain or, when it is older, stands alone.
  Link Add(const WheelSample& sample);

  // Forgets the chain: time began anew.
  void Clear();

 private:
  bool Plausible(const WheelSample& interval) const;

  DrEkfConfig config_;
  DurationUs period_;
  std::optional<Utime> end_;  // of the newest sample, as it was stamped
  std::optional<Utime> used_until_;
  std::optional<WheelSample> waiting_;
};

}  // namespace gw::dr_ekf

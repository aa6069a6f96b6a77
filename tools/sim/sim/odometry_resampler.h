// A base driver between the encoders and the bus: it reads the newest encoder packet in a loop of
// its own and stamps what was driven since with the time of the loop. Increments of 20 Hz made from
// packets of 50 Hz alternately cover 40 and 60 ms and are stamped every 50 ms; the stamps are late
// besides, because the loop shares a computer.
#pragma once

#include <cstdint>
#include <optional>

#include "common/contract/samples.h"
#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw::sim {

struct OdometryConfig {
  double rate_hz = 20;         // 0: every packet as it is, with its ticks and heading
  double stamp_jitter_ms = 2;  // the loop wakes late by the size of a normal variable
  double delay_s = 0.0475;     // all stamps are late by this, and the configuration knows it
};

class OdometryResampler {
 public:
  OdometryResampler(const OdometryConfig& config, Utime start, uint64_t seed);

  // An encoder packet, by the base's own time.
  void Push(const WheelSample& packet);
  // What the driver sends at this instant, if anything; ask at least once a millisecond.
  std::optional<WheelSample> Take(Utime now);

 private:
  Utime NextTurn() const;

  OdometryConfig config_;
  Utime start_;
  uint64_t seed_;
  int64_t turn_ = 0;  // of the loop
  Utime last_stamp_;
  SE3 driven_;  // since the sample before
  ContactFlags contact_;
  std::optional<WheelSample> packet_;  // newest, when there is no loop
};

}  // namespace gw::sim

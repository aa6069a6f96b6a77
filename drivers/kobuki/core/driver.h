// The Kobuki driver without its serial port: bytes and commands in, samples and bytes out. Times
// come with the calls, must not decrease, and are of the robot's one clock
// (common/process/clock.h).
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/camera/calibration.h"
#include "common/config/kobuki_config.h"
#include "common/contract/health.h"
#include "common/contract/samples.h"
#include "drivers/common/device_clock.h"
#include "drivers/kobuki/core/battery.h"
#include "drivers/kobuki/core/command_shaper.h"
#include "drivers/kobuki/core/frame_sequence.h"
#include "drivers/kobuki/core/gyro.h"
#include "drivers/kobuki/core/odometry.h"
#include "drivers/kobuki/core/safety_guard.h"
#include "drivers/kobuki/protocol/feedback.h"
#include "drivers/kobuki/protocol/frame.h"
#include "drivers/kobuki/protocol/output_word.h"

namespace gw::kobuki {

struct Identity {
  std::optional<Version> hardware;
  std::optional<Version> firmware;
  std::optional<Udid> udid;
  bool complete() const { return hardware && firmware && udid; }
};

// How the driver is doing, in HEALTH's words.
struct Condition {
  HealthState state = HealthState::kStarting;
  std::string message;
};

class Driver {
 public:
  struct Samples {
    std::vector<WheelSample> wheel;  // in order; utime strictly increases, seq without gaps from 1
    std::vector<ImuSample> imu;      // gyro in B, stationary bias removed; the same promises
  };

  Driver(const KobukiConfig& config, const WheelCalibration& wheel);

  // Bytes that one read gave at `arrival`.
  Samples Receive(std::span<const uint8_t> bytes, Utime arrival);
  void Command(const BaseCommand& command, Utime now);
  // To be called every few milliseconds; gives the bytes to send now, often none. Every 20 ms they
  // hold a motion command, a stop when nothing else is wanted or known to be safe. Nothing before
  // the first valid frame: until then it may be any device.
  std::vector<uint8_t> Tick(Utime now);
  // The stop that the shell sends before it closes the port.
  static std::vector<uint8_t> StopBytes();

  // The port was opened anew: partial frames and the robot's state are forgotten, sequence numbers
  // go on.
  void PortOpened(Utime now);

  bool talking(Utime now) const;  // a valid frame within the last kSilent
  Condition GetCondition(Utime now) const;
  // Counters, and the newest battery_mv, battery_percent, charging, delays; sorted by name.
  std::vector<std::pair<std::string, int64_t>> Counters() const;

  const Identity& identity() const { return identity_; }
  const FrameCounters& frame_counters() const { return parser_.counters(); }
  const BatteryState& battery() const { return battery_; }
  SafetyGuard::Stop stop() const { return guard_.stop(); }
  Twist driving() const { return driving_; }  // what the base was last told
  // Least time from a request to the frame that answers it: an upper bound of the constant delay
  // from measurement to arrival, and close to it when commands arrive fast. 0: not yet measured.
  DurationUs round_trip() const { return round_trip_; }
  DurationUs worst_wait() const { return worst_wait_; }
  const DeviceClock& clock() const { return clock_; }

  static constexpr DurationUs kCommandPeriod = Milliseconds(20);
  // A pause in the middle of a frame after which its rest is not waited for. Longer than a host or
  // an adapter may sleep: a shorter limit (40 ms) costs a frame with each stall and gains nothing,
  // since bytes that follow a broken frame expose it anyway.
  static constexpr DurationUs kPartialGap = Milliseconds(200);
  // Without feedback for this long nothing is known about cliffs: the base is told to stop.
  static constexpr DurationUs kSilent = Milliseconds(200);

 private:
  void Accept(const Frame& frame, Utime arrival, Samples* out);
  // begin: when the first byte of the frame arrived, at the latest.
  void AcceptBasic(const Feedback& feedback, Utime begin, Samples* out);
  void AcceptIdentity(const Feedback& feedback, Utime begin);
  void AcceptGyro(const RawGyro& gyro, int64_t robot_us, Samples* out);
  void Restart(bool rebooted);
  void AppendRequest(Utime now, std::vector<uint8_t>* out);
  OutputWord WantedOutput(Utime now) const;
  bool firmware_refused() const { return identity_.firmware && identity_.firmware->major != 1; }
  Utime Measured(int64_t robot_us) const;

  KobukiConfig config_;
  WheelCalibration wheel_;

  FrameParser parser_;
  FrameSequence sequence_;
  DeviceClock clock_;
  GyroTiming gyro_timing_;
  StationaryBias bias_;
  SafetyGuard guard_;
  CommandShaper shaper_;

  Identity identity_;
  BatteryState battery_;
  uint8_t over_current_ = 0;
  Twist driving_;
  OutputWord output_sent_;

  std::optional<Utime> last_bytes_;
  std::optional<Utime> last_frame_;
  std::optional<Utime> last_command_sent_;
  std::optional<Utime> last_output_sent_;
  std::optional<Utime> last_request_sent_;
  std::optional<Utime> awaiting_answer_since_;
  DurationUs round_trip_;
  DurationUs worst_wait_;

  // The wheel sample before: where the next begins.
  std::optional<Utime> wheel_utime_;
  WheelTicks wheel_ticks_;
  ContactFlags latched_;
  bool stationary_ = false;
  std::optional<Utime> imu_utime_;

  int64_t wheel_seq_ = 0;
  int64_t imu_seq_ = 0;
  int64_t decoded_bad_length_ = 0;
  int64_t unknown_ = 0;
  int64_t duplicates_ = 0;
  int64_t merged_ = 0;  // frames without a sample of their own: mapped not after the one before
  int64_t commands_ = 0;
  int64_t commands_refused_ = 0;
  int64_t imu_dropped_ = 0;
};

}  // namespace gw::kobuki

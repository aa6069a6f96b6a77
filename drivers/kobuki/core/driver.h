// The Kobuki driver without its serial port: bytes and commands go in, samples and bytes come out.
// Times come with the calls, must not decrease, and are of the robot's one clock
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

// The state of the driver, in the terms of HEALTH.
struct Condition {
  HealthState state = HealthState::kStarting;
  std::string message;
};

class Driver {
 public:
  struct Samples {
    // In order: utime strictly increases, seq counts from 1 without gaps.
    std::vector<WheelSample> wheel;
    std::vector<ImuSample> imu;  // gyro in B without its stationary bias, in the same order
  };

  Driver(const KobukiConfig& config, const WheelCalibration& wheel);

  // Takes the bytes that one read gave at `arrival`, and gives the samples that they complete.
  Samples Receive(std::span<const uint8_t> bytes, Utime arrival);
  void Command(const BaseCommand& command, Utime now);
  // Gives the bytes to send now, often none; to be called every few milliseconds. Every 20 ms they
  // hold a motion command, which is a stop when nothing else is wanted or known to be safe. Nothing
  // is sent before the first valid frame: until then the device may be any.
  std::vector<uint8_t> Tick(Utime now);
  // The stop that the shell sends before it closes the port.
  static std::vector<uint8_t> StopBytes();

  // To be called when the port was opened anew: partial frames and the robot's state are forgotten,
  // sequence numbers go on.
  void PortOpened(Utime now);

  bool talking(Utime now) const;  // true when a valid frame came within the last kSilent
  Condition GetCondition(Utime now) const;
  // Counters, and the newest battery_mv, battery_percent, charging, delays; sorted by name.
  std::vector<std::pair<std::string, int64_t>> Counters() const;

  const Identity& identity() const { return identity_; }
  const FrameCounters& frame_counters() const { return parser_.counters(); }
  const BatteryState& battery() const { return battery_; }
  SafetyGuard::Stop stop() const { return guard_.stop(); }
  Twist driving() const { return driving_; }  // what the base was last told
  // The least time from a request to the frame that answers it: an upper bound of the constant
  // delay from measurement to arrival, and close to it when commands arrive fast. 0 while it is not
  // measured.
  DurationUs round_trip() const { return round_trip_; }
  DurationUs worst_wait() const { return worst_wait_; }
  const DeviceClock& clock() const { return clock_; }

  static constexpr DurationUs kCommandPeriod = Milliseconds(20);
  // After a pause of this length in the middle of a frame its rest is not waited for. It is longer
  // than a host or an adapter may sleep: a shorter limit (40 ms) costs a frame with each stall and
  // gains nothing, since bytes that follow a broken frame expose it anyway.
  static constexpr DurationUs kPartialGap = Milliseconds(200);
  // Without feedback for this long nothing is known about cliffs: the base is told to stop.
  static constexpr DurationUs kSilent = Milliseconds(200);

 private:
  void Accept(const Frame& frame, Utime arrival, Samples* out);
  // `begin` is when the first byte of the frame arrived, at the latest.
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

  // Time of the wheel sample before, where the next one begins.
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
  // Frames without a sample of their own: their time is not after that of the one before.
  int64_t merged_ = 0;
  int64_t commands_ = 0;
  int64_t commands_refused_ = 0;
  int64_t imu_dropped_ = 0;
};

}  // namespace gw::kobuki

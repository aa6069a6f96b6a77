// A Kobuki base in virtual time: wheels with dead time and lag, encoders, gyro, 50 frames a second,
// answers to requests, and the line to the host with its USB adapter. Same configuration, seed and
// calls: same bytes at the same times.
//
// Faults are switched on by the configuration or while it runs. Time is that of the host's clock,
// without error: the truth that drivers are measured against.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "common/core/random.h"
#include "common/core/time.h"
#include "drivers/kobuki/protocol/frame.h"
#include "test/emulators/kobuki/wire_peer.h"

namespace gw::kobuki {

struct EmulatorConfig {
  uint64_t seed = 1;
  Utime start{1'000'000'000};  // power-on; frames begin at once

  // These describe the robot.
  double clock_ppm = 0;  // how much the robot's clock runs fast
  uint16_t first_timestamp_ms = 0;
  uint16_t first_left_ticks = 0;
  uint16_t first_right_ticks = 0;
  double dead_time_s = 0.17;  // command to first motion: about 200 ms were measured with the lag
  double lag_s = 0.1;         // lag of the wheels, first order
  double gyro_rate_hz = 103;
  std::array<double, 3> gyro_bias_lsb{12, -7, -70};
  double gyro_noise_lsb = 6;
  Version hardware{1, 0, 4};
  Version firmware{1, 2, 0};
  Udid udid{{97713968, 842422349, 1361404194}};
  VersionForm version_form = VersionForm::kFourBytes;
  bool answers_in_own_frame = false;
  uint8_t battery_dv = 163;
  uint8_t charger = 0;

  // These describe the line to the host.
  DurationUs frame_jitter{1000};   // jitter of the start of each frame, either way
  DurationUs transport_delay{0};   // delay from measurement to the first byte on the line
  DurationUs latency_timer{1000};  // timer of the USB adapter: 1 ms or 16 ms
  DurationUs host_jitter{200};     // mean of an exponential delay of each delivery
  double stall_rate_hz = 0;        // how often the host sleeps ...
  DurationUs stall{60'000};        // ... and for how long; then everything comes in one burst
  DurationUs command_delay{1000};  // delay from host to robot

  // Faults; each number is the probability per byte or per frame.
  double drop_byte = 0;
  double flip_bit = 0;
  double garbage_burst = 0;        // noise of up to 100 bytes before a frame
  double duplicate_timestamp = 0;  // the frame repeats the time of the one before
  double unknown_sub_payload = 0;
};

class Emulator {
 public:
  struct Delivery {
    Utime at;  // when the host can read them
    std::vector<uint8_t> bytes;
  };
  // The truth at the instant when a frame was measured.
  struct FrameTruth {
    Utime measured;
    uint16_t timestamp_ms = 0;
    uint16_t left_ticks = 0, right_ticks = 0;
    double x_m = 0, y_m = 0, yaw_rad = 0;
  };
  struct GyroTruth {
    Utime measured;
    std::array<double, 3> w_B_rad_s{};
  };

  explicit Emulator(const EmulatorConfig& config);

  // Takes bytes that the host wrote at `at`, which must not be before the time that was advanced
  // to.
  void Write(std::span<const uint8_t> bytes, Utime at);
  // Simulates up to `now`, and gives what the host could read by then and has not got yet.
  std::vector<Delivery> AdvanceTo(Utime now);

  // Sets the contacts from the next frame on; bits as in BasicData.
  void SetContact(uint8_t bumper, uint8_t wheel_drop, uint8_t cliff);
  void SetBattery(uint8_t dv, uint8_t charger);
  void SetOverCurrent(uint8_t bits) { over_current_ = bits; }
  // Switches the base off, or unplugs the cable on the robot's side: the line stays, no data comes.
  void SetSilent(bool silent) { silent_ = silent; }
  // Switches off and on again: clock, encoders, gyro heading, commands and outputs begin anew.
  void Reboot();
  // Pushes the robot by hand: the wheels turn without command.
  void Push(double left_m_s, double right_m_s);

  double v_m_s() const { return (left_.speed + right_.speed) / 2; }
  double w_rad_s() const { return (right_.speed - left_.speed) / kTrackM; }
  double x_m() const { return x_; }
  double y_m() const { return y_; }
  double yaw_rad() const { return yaw_; }
  uint16_t output() const { return output_; }
  Twist commanded() const { return commanded_; }
  int64_t commands() const { return commands_; }
  std::optional<Utime> last_command() const { return last_command_; }
  const std::vector<FrameTruth>& frames() const { return frames_; }
  const std::vector<GyroTruth>& gyro() const { return gyro_truth_; }

  static constexpr double kTrackM = 0.23;
  static constexpr double kTicksPerMetre = 11724.4166;

 private:
  struct Wheel {
    double target = 0;  // target speed after the dead time, m/s
    double speed = 0;
    double pushed = 0;
    double way = 0;  // way since power-on, m
  };
  struct Pending {
    Utime at;
    double left = 0, right = 0;
  };
  struct LineByte {
    Utime at;  // its last bit has reached the adapter
    uint8_t value = 0;
  };
  struct Incoming {
    Utime at;
    std::vector<uint8_t> bytes;
  };

  void Step();  // simulates one millisecond
  void MoveWheels(double dt);
  void Obey(const Commands& commands);
  void SampleGyro();
  void MakeFrame();
  void PutOnLine(const std::vector<uint8_t>& frame);
  void ServeAdapter();
  void Deliver(std::vector<uint8_t> bytes, Utime at);
  uint16_t Ticks(const Wheel& wheel, uint16_t first) const;
  double RobotMs() const;

  EmulatorConfig config_;
  CounterRng rng_;
  Utime now_;
  Utime powered_;
  int64_t next_frame_ = 0;
  double next_frame_ms_ = 0;  // time of the next frame on the robot's clock
  int64_t gyro_samples_ = 0;

  Wheel left_, right_;
  double x_ = 0, y_ = 0, yaw_ = 0;
  double heading_zero_ = 0;
  std::deque<Pending> pending_;
  Twist commanded_;
  int64_t commands_ = 0;
  std::optional<Utime> last_command_;
  uint16_t output_ = 0x00F0;
  uint16_t requested_ = 0;
  bool gains_requested_ = false;
  ControllerInfo gains_{0, 100000, 100, 2000};

  uint8_t bumper_ = 0, wheel_drop_ = 0, cliff_ = 0, over_current_ = 0;
  bool silent_ = false;
  RawGyro gyro_queue_;
  uint16_t last_timestamp_ms_ = 0;

  FrameParser parser_;
  std::deque<Incoming> incoming_;
  std::deque<LineByte> line_;
  Utime line_free_;
  std::vector<uint8_t> packet_;  // the bytes that wait in the adapter
  Utime packet_since_;
  Utime last_delivery_;
  Utime stall_until_;
  std::deque<Delivery> deliveries_;

  std::vector<FrameTruth> frames_;
  std::vector<GyroTruth> gyro_truth_;
};

}  // namespace gw::kobuki

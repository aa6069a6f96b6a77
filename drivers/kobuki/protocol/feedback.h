// The feedback of the Kobuki, 50 times a second: the sub-payloads of a feedback frame as plain
// structs in the units of the protocol. Source: Kobuki protocol, yujinrobot kobuki_driver
// documentation, and kobuki_core 1.4; see drivers/kobuki/README.md.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace gw::kobuki {

// The feedback ids, which are a name space of their own: commands use the same numbers for other
// things.
enum class FeedbackId : uint8_t {
  kBasic = 1,
  kDockingIr = 3,
  kInertial = 4,
  kCliff = 5,
  kCurrent = 6,
  kHardwareVersion = 10,
  kFirmwareVersion = 11,
  kRawGyro = 13,
  kGpInput = 16,
  kUdid = 19,
  kControllerInfo = 21,
};

// The bits of bumper and cliff.
inline constexpr uint8_t kRightBit = 0x01;
inline constexpr uint8_t kCentreBit = 0x02;
inline constexpr uint8_t kLeftBit = 0x04;
// The bits of wheel drop; those of over-current are the other way round.
inline constexpr uint8_t kRightWheelDropBit = 0x01;
inline constexpr uint8_t kLeftWheelDropBit = 0x02;
inline constexpr uint8_t kLeftOverCurrentBit = 0x01;
inline constexpr uint8_t kRightOverCurrentBit = 0x02;

struct BasicData {
  uint16_t timestamp_ms = 0;  // the robot's clock, which wraps every 65.536 s
  uint8_t bumper = 0;         // kRightBit and its like are set while pressed
  uint8_t wheel_drop = 0;     // bits are set while the wheel hangs
  uint8_t cliff = 0;          // kRightBit and its like are set while floor is missing
  uint16_t left_encoder = 0;  // ticks, which wrap; forward counts up
  uint16_t right_encoder = 0;
  int8_t left_pwm = 0;  // signed duty cycle
  int8_t right_pwm = 0;
  uint8_t buttons = 0;     // bit i is set while button i is pressed
  uint8_t charger = 0;     // 0 discharging, 2 charged, 6 charging, plus 0x10 from the adapter
  uint8_t battery_dv = 0;  // 0.1 V
  uint8_t over_current = 0;
  bool operator==(const BasicData&) const = default;
};

// The bits of what each receiver sees are 0x01 near left, 0x02 near centre, 0x04 near right, 0x08
// far centre, 0x10 far left, 0x20 far right.
struct DockingIr {
  uint8_t right = 0, centre = 0, left = 0;
  bool operator==(const DockingIr&) const = default;
};

// The heading that the firmware integrates from its gyro, without the bias that it found at
// power-on.
struct Inertial {
  int16_t angle_cdeg = 0;   // 0.01 deg, counter-clockwise; any zero, wraps by whole turns
  int16_t rate_cdeg_s = 0;  // 0.01 deg/s
  bool operator==(const Inertial&) const = default;
};

struct CliffAdc {
  uint16_t right = 0, centre = 0, left = 0;  // 0..4095 for 0..3.3 V; higher is nearer
  bool operator==(const CliffAdc&) const = default;
};

struct MotorCurrent {
  uint8_t left_10ma = 0, right_10ma = 0;
  bool operator==(const MotorCurrent&) const = default;
};

struct Version {
  int major = 0, minor = 0, patch = 0;
  bool operator==(const Version&) const = default;
};

// Samples in the axes of the sensor and with its bias; GyroRate() in the core turns them.
struct RawGyro {
  // Number of samples[0]; each sample has one more, and it wraps.
  uint8_t first_id = 0;
  std::vector<std::array<int16_t, 3>> samples;  // x, y, z; oldest first; 1 to kMaxGyroSamples
  bool operator==(const RawGyro&) const = default;
};
inline constexpr size_t kMaxGyroSamples = 8;

struct GpInput {
  uint16_t digital = 0;              // bits 0..3 are set for inputs that are high
  std::array<uint16_t, 4> analog{};  // 0..4095 for 0..3.3 V; an open input reads about 4095
  bool operator==(const GpInput&) const = default;
};

struct Udid {
  std::array<uint32_t, 3> words{};
  bool operator==(const Udid&) const = default;
};

struct ControllerInfo {
  uint8_t type = 0;                                // 0 factory gains, 1 user gains
  uint32_t p_milli = 0, i_milli = 0, d_milli = 0;  // gains times 1000
  bool operator==(const ControllerInfo&) const = default;
};

// The content of one frame; parts that the frame did not hold are absent.
struct Feedback {
  std::optional<BasicData> basic;
  std::optional<DockingIr> docking_ir;
  std::optional<Inertial> inertial;
  std::optional<CliffAdc> cliff;
  std::optional<MotorCurrent> current;
  std::optional<Version> hardware;
  std::optional<Version> firmware;
  std::optional<RawGyro> raw_gyro;
  std::optional<GpInput> gp_input;
  std::optional<Udid> udid;
  std::optional<ControllerInfo> controller;
  int unknown = 0;     // sub-payloads that were skipped because their id is unknown
  int bad_length = 0;  // sub-payloads that were skipped because their length does not fit their id
  bool operator==(const Feedback&) const = default;
};

// Reads a payload. It never fails: what it does not understand it skips and counts. A payload that
// SplitPayload() refuses gives an empty Feedback.
Feedback DecodeFeedback(std::span<const uint8_t> payload);

}  // namespace gw::kobuki

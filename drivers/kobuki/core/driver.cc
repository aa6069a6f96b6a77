#include "drivers/kobuki/core/driver.h"

#include <algorithm>
#include <cmath>

#include "drivers/kobuki/protocol/command.h"

namespace gw::kobuki {
namespace {

// The track width that the firmware computes with; the calibrated one only interprets ticks.
constexpr double kFirmwareTrackM = 0.23;
// The time of one byte on the line: 10 bits at 115200 baud.
constexpr double kByteUs = 86.8;
constexpr DurationUs kAskIdentityEvery{1'000'000};
// Requests after the first only measure the round trip. The interval is not a multiple of the frame
// period, so that they meet all its phases.
constexpr DurationUs kAskAgainEvery{5'003'000};
constexpr DurationUs kAnswerTimeout{1'000'000};
// The output word is sent again at this interval: it is not acknowledged, and a reboot of the base
// forgets it.
constexpr DurationUs kOutputEvery{1'000'000};

void Append(const std::vector<uint8_t>& bytes, std::vector<uint8_t>* out) {
  out->insert(out->end(), bytes.begin(), bytes.end());
}

bool Due(const std::optional<Utime>& last, DurationUs period, Utime now) {
  return !last || now - *last >= period;
}

std::string Text(const Version& v) {
  return std::to_string(v.major) + "." + std::to_string(v.minor) + "." + std::to_string(v.patch);
}

const char* StopText(SafetyGuard::Stop stop) {
  switch (stop) {
    case SafetyGuard::Stop::kNone:
      return "";
    case SafetyGuard::Stop::kBumper:
      return "bumper pressed: back off to go on";
    case SafetyGuard::Stop::kCliff:
      return "no floor under a cliff sensor: back off to go on";
    case SafetyGuard::Stop::kWheelDrop:
      return "a wheel hangs: put the base on the floor and send a stop to go on";
  }
  return "";
}

}  // namespace

Driver::Driver(const KobukiConfig& config, const WheelCalibration& wheel)
    : config_(config), wheel_(wheel), shaper_(config) {}

void Driver::PortOpened(Utime now) {
  (void)parser_.AbandonPartial();
  last_bytes_ = now;
  last_frame_.reset();
  last_output_sent_.reset();
  last_request_sent_.reset();
  awaiting_answer_since_.reset();
  shaper_.Halt();
}

Driver::Samples Driver::Receive(std::span<const uint8_t> bytes, Utime arrival) {
  Samples out;
  if (last_bytes_ && arrival - *last_bytes_ > kPartialGap && parser_.has_partial()) {
    for (const Frame& frame : parser_.AbandonPartial()) Accept(frame, *last_bytes_, &out);
  }
  last_bytes_ = arrival;
  for (const Frame& frame : parser_.Push(bytes)) {
    // The bytes that stand behind the frame took their time on the line after it.
    const double behind_us = kByteUs * static_cast<double>(frame.bytes_after);
    Accept(frame, arrival - DurationUs{std::llround(behind_us)}, &out);
  }
  return out;
}

void Driver::Accept(const Frame& frame, Utime arrival, Samples* out) {
  const Feedback feedback = DecodeFeedback(frame.payload);
  unknown_ += feedback.unknown;
  decoded_bad_length_ += feedback.bad_length;
  last_frame_ = arrival;
  // The sample was measured before the frame began, not when its last byte came.
  const double on_line_us = kByteUs * static_cast<double>(frame.payload.size() + kFrameOverhead);
  const Utime begin = arrival - DurationUs{std::llround(on_line_us)};
  AcceptIdentity(feedback, begin);
  if (feedback.basic) AcceptBasic(feedback, begin, out);
}

void Driver::AcceptIdentity(const Feedback& feedback, Utime begin) {
  if (feedback.hardware) identity_.hardware = feedback.hardware;
  if (feedback.firmware) identity_.firmware = feedback.firmware;
  if (feedback.udid) identity_.udid = feedback.udid;
  if (!awaiting_answer_since_ || !feedback.hardware) return;
  const DurationUs trip = begin - *awaiting_answer_since_;
  awaiting_answer_since_.reset();
  if (trip.us > 0 && trip < kAnswerTimeout && (round_trip_.us == 0 || trip < round_trip_)) {
    round_trip_ = trip;
  }
}

void Driver::AcceptBasic(const Feedback& feedback, Utime begin, Samples* out) {
  const BasicData& basic = *feedback.basic;
  const WheelTicks ticks{basic.left_encoder, basic.right_encoder};
  const auto judged = sequence_.Judge({basic.timestamp_ms, ticks.left, ticks.right, begin});
  if (judged.verdict == FrameSequence::Verdict::kHeld) return;

  const ContactFlags contact{basic.bumper != 0, basic.cliff != 0, basic.wheel_drop != 0};
  guard_.Sense(contact, begin);
  latched_.bumper |= contact.bumper;
  latched_.cliff |= contact.cliff;
  latched_.wheel_drop |= contact.wheel_drop;
  battery_ = ReadBattery(basic.battery_dv, basic.charger);
  over_current_ = basic.over_current;

  if (judged.verdict == FrameSequence::Verdict::kRestarts) Restart(judged.rebooted);
  if (judged.verdict == FrameSequence::Verdict::kDuplicate) {
    ++duplicates_;
  } else {
    clock_.Add(judged.robot_us, begin);
    if (clock_.ready()) worst_wait_ = std::max(worst_wait_, clock_.waited());
  }
  if (!clock_.ready()) {
    wheel_utime_.reset();
    return;
  }
  if (feedback.raw_gyro) AcceptGyro(*feedback.raw_gyro, judged.robot_us, out);
  if (judged.verdict == FrameSequence::Verdict::kDuplicate) return;

  const Utime utime = Measured(judged.robot_us);
  if (wheel_utime_ && utime <= *wheel_utime_) {
    ++merged_;
    return;
  }
  stationary_ = false;
  if (wheel_utime_) {
    const PlanarMotion motion = MotionBetween(wheel_ticks_, ticks, wheel_);
    WheelSample sample;
    sample.utime = utime;
    sample.utime_begin = *wheel_utime_;
    sample.seq = ++wheel_seq_;
    sample.has_ticks = true;
    sample.left_ticks = ticks.left;
    sample.right_ticks = ticks.right;
    sample.dx_m = motion.dx_m;
    sample.dy_m = motion.dy_m;
    sample.dyaw_rad = motion.dyaw_rad;
    if (feedback.inertial) {
      sample.has_heading = true;
      sample.heading_rad = HeadingFromCentidegrees(feedback.inertial->angle_cdeg);
    }
    sample.contact = latched_;
    out->wheel.push_back(sample);
    stationary_ = ticks.left == wheel_ticks_.left && ticks.right == wheel_ticks_.right &&
                  basic.left_pwm == 0 && basic.right_pwm == 0 && !contact.wheel_drop;
  }
  wheel_utime_ = utime;
  wheel_ticks_ = ticks;
  latched_ = {};
}

void Driver::AcceptGyro(const RawGyro& gyro, int64_t robot_us, Samples* out) {
  const GyroTiming::Times times = gyro_timing_.Stamp(gyro, robot_us);
  for (size_t i = times.first_new; i < gyro.samples.size(); ++i) {
    const Eigen::Vector3d w = GyroRate(gyro.samples[i]);
    bias_.Add(w, stationary_);
    ImuSample sample;
    sample.utime = Measured(times.robot_us[i]);
    if (imu_utime_ && sample.utime <= *imu_utime_) {
      ++imu_dropped_;
      continue;
    }
    imu_utime_ = sample.utime;
    sample.seq = ++imu_seq_;
    sample.w_I_rad_s = w - bias_.bias_rad_s();
    out->imu.push_back(sample);
  }
}

void Driver::Restart(bool rebooted) {
  wheel_utime_.reset();
  gyro_timing_.Reset();
  if (!rebooted) return;
  clock_.Reset();
  shaper_.Halt();  // the base stands and has to accelerate anew
  // Another base may be at the cable now.
  identity_ = {};
  last_request_sent_.reset();
  last_output_sent_.reset();
}

Utime Driver::Measured(int64_t robot_us) const {
  return clock_.ToHost(robot_us) - DurationFromSeconds(config_.transport_delay_ms * 1e-3);
}

void Driver::Command(const BaseCommand& command, Utime now) {
  ++commands_;
  commands_refused_ += !shaper_.Push(command, now);
}

std::vector<uint8_t> Driver::Tick(Utime now) {
  std::vector<uint8_t> out;
  if (!last_frame_) return out;
  if (talking(now)) AppendRequest(now, &out);
  if (!Due(last_command_sent_, kCommandPeriod, now)) return out;
  last_command_sent_ = now;

  const Twist wanted = shaper_.Wanted(now);
  Twist allowed = guard_.Filter(wanted, now);
  const bool blind = !talking(now);
  if (blind || firmware_refused()) allowed = {};
  const bool stopped =
      (wanted.v_m_s != 0 || wanted.w_rad_s != 0) && allowed.v_m_s == 0 && allowed.w_rad_s == 0;
  if (stopped || guard_.stop() == SafetyGuard::Stop::kWheelDrop || blind) shaper_.Halt();
  driving_ = shaper_.Step(allowed, now);
  // The ramp must not roll on into what just stopped the base.
  if (guard_.stop() != SafetyGuard::Stop::kNone && driving_.v_m_s > 0) {
    shaper_.Halt();
    driving_ = {};
  }

  CommandFrame frame;
  frame.Drive(MakeBaseControl(driving_, kFirmwareTrackM));
  const OutputWord output = WantedOutput(now);
  if (!blind && (output != output_sent_ || Due(last_output_sent_, kOutputEvery, now))) {
    frame.Output(output.value());
    output_sent_ = output;
    last_output_sent_ = now;
  }
  Append(frame.Encode(), &out);
  return out;
}

void Driver::AppendRequest(Utime now, std::vector<uint8_t>* out) {
  const bool complete = identity_.complete();
  if (!Due(last_request_sent_, complete ? kAskAgainEvery : kAskIdentityEvery, now)) return;
  last_request_sent_ = now;
  awaiting_answer_since_ = now;
  const uint16_t flags = complete ? kRequestHardwareVersion : kRequestIdentity;
  Append(CommandFrame().RequestExtra(flags).Encode(), out);
}

std::vector<uint8_t> Driver::StopBytes() {
  return CommandFrame().Drive({}).Encode();
}

// The word that the LEDs should show. LED 1 is green when all is well, orange without a command,
// red when stopped; LED 2 is green, orange for a low and red for a critical battery.
OutputWord Driver::WantedOutput(Utime now) const {
  const bool stopped = guard_.stop() != SafetyGuard::Stop::kNone || firmware_refused();
  OutputWord out;
  out.Set(Led::kLed1, stopped                  ? LedColour::kRed
                      : shaper_.commanded(now) ? LedColour::kGreen
                                               : LedColour::kOrange);
  out.Set(Led::kLed2, battery_.critical ? LedColour::kRed
                      : battery_.low    ? LedColour::kOrange
                                        : LedColour::kGreen);
  return out;
}

bool Driver::talking(Utime now) const {
  return last_frame_ && now - *last_frame_ <= kSilent;
}

Condition Driver::GetCondition(Utime now) const {
  if (firmware_refused()) {
    return {HealthState::kFailed, "firmware " + Text(*identity_.firmware) +
                                      " is not known to this driver (1.x is): motion is refused"};
  }
  if (!talking(now)) {
    return {HealthState::kDegraded, "no data from the base: is it switched on?"};
  }
  if (!clock_.ready()) return {HealthState::kStarting, "waiting for the base's clock to settle"};
  std::string message;
  const auto add = [&message](const std::string& text) {
    if (!text.empty()) message += (message.empty() ? "" : "; ") + text;
  };
  add(StopText(guard_.stop()));
  if (over_current_ != 0) add("over-current at a wheel: free it");
  if (battery_.critical) {
    add("battery nearly empty: charge now");
  } else if (battery_.low) {
    add("battery low: charge");
  }
  if (identity_.firmware) {
    const Version& v = *identity_.firmware;
    if (v != Version{1, 1, 4} && v != Version{1, 2, 0}) {
      add("firmware " + Text(v) + " has known faults: update to 1.2.0");
    }
  }
  return {message.empty() ? HealthState::kOk : HealthState::kDegraded, message};
}

std::vector<std::pair<std::string, int64_t>> Driver::Counters() const {
  const FrameCounters& f = parser_.counters();
  std::vector<std::pair<std::string, int64_t>> out = {
      {"kobuki.bad_checksum", f.bad_checksum},
      {"kobuki.bad_frame_length", f.bad_length},
      {"kobuki.bad_sub_payload", decoded_bad_length_},
      {"kobuki.battery_mv", std::llround(1000 * battery_.volts)},
      {"kobuki.battery_percent", std::llround(battery_.percent)},
      {"kobuki.bytes", f.bytes},
      {"kobuki.charging", battery_.charging == Charging::kNo ? 0 : 1},
      {"kobuki.clock_steps", clock_.steps()},
      {"kobuki.commands", commands_},
      {"kobuki.commands_refused", commands_refused_},
      {"kobuki.corrupt_frames", sequence_.corrupt()},
      {"kobuki.duplicate_frames", duplicates_},
      {"kobuki.frames", f.frames},
      {"kobuki.gyro_lost", gyro_timing_.lost() + imu_dropped_},
      {"kobuki.malformed", f.malformed},
      {"kobuki.merged_frames", merged_},
      {"kobuki.reboots", sequence_.reboots()},
      {"kobuki.restarts", sequence_.restarts()},
      {"kobuki.round_trip_us", round_trip_.us},
      {"kobuki.safety_stops", guard_.stops()},
      {"kobuki.skipped_bytes", f.skipped_bytes},
      {"kobuki.unknown_sub_payload", unknown_},
      {"kobuki.worst_wait_us", worst_wait_.us},
  };
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace gw::kobuki

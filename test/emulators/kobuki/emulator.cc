#include "test/emulators/kobuki/emulator.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/check.h"

namespace gw::kobuki {
namespace {

constexpr int64_t kStepUs = 1000;
constexpr double kByteUs = 86.8;   // time of one byte: 10 bits at 115200 baud
constexpr size_t kUsbPacket = 62;  // bytes of payload in a full-speed packet of the FT232R
constexpr double kLsb = 0.00875 * std::numbers::pi / 180;

int16_t Saturate(double value) {
  return static_cast<int16_t>(std::clamp(std::round(value), -32768.0, 32767.0));
}

}  // namespace

Emulator::Emulator(const EmulatorConfig& config)
    : config_(config), rng_(config.seed, 0x6B6F62, 0), now_(config.start) {
  powered_ = now_;
  line_free_ = now_;
  packet_since_ = now_;
  last_delivery_ = now_;
  stall_until_ = now_;
}

void Emulator::Write(std::span<const uint8_t> bytes, Utime at) {
  incoming_.push_back({at + config_.command_delay, {bytes.begin(), bytes.end()}});
}

std::vector<Emulator::Delivery> Emulator::AdvanceTo(Utime now) {
  while (now_ + DurationUs{kStepUs} <= now) Step();
  std::vector<Delivery> out;
  while (!deliveries_.empty() && deliveries_.front().at <= now) {
    out.push_back(std::move(deliveries_.front()));
    deliveries_.pop_front();
  }
  return out;
}

void Emulator::SetContact(uint8_t bumper, uint8_t wheel_drop, uint8_t cliff) {
  bumper_ = bumper;
  wheel_drop_ = wheel_drop;
  cliff_ = cliff;
}

void Emulator::SetBattery(uint8_t dv, uint8_t charger) {
  config_.battery_dv = dv;
  config_.charger = charger;
}

void Emulator::Push(double left_m_s, double right_m_s) {
  left_.pushed = left_m_s;
  right_.pushed = right_m_s;
}

void Emulator::Reboot() {
  powered_ = now_;
  next_frame_ = 0;
  next_frame_ms_ = 0;
  gyro_samples_ = 0;
  left_ = {};
  right_ = {};
  heading_zero_ = yaw_;
  pending_.clear();
  commanded_ = {};
  output_ = 0x00F0;
  requested_ = 0;
  gyro_queue_ = {};
  config_.first_timestamp_ms = 0;
  config_.first_left_ticks = 0;
  config_.first_right_ticks = 0;
}

double Emulator::RobotMs() const {
  return static_cast<double>((now_ - powered_).us) * 1e-3 * (1 + config_.clock_ppm * 1e-6);
}

uint16_t Emulator::Ticks(const Wheel& wheel, uint16_t first) const {
  const auto ticks = static_cast<int64_t>(std::floor(wheel.way * kTicksPerMetre));
  return static_cast<uint16_t>(first + ticks);
}

void Emulator::Step() {
  now_ = now_ + DurationUs{kStepUs};
  while (!incoming_.empty() && incoming_.front().at <= now_) {
    auto frames = parser_.Push(incoming_.front().bytes);
    for (Frame& frame : parser_.AbandonPartial()) frames.push_back(std::move(frame));
    if (!silent_) {
      for (const Frame& frame : frames) Obey(DecodeCommands(frame.payload));
    }
    incoming_.pop_front();
  }
  while (!pending_.empty() && pending_.front().at <= now_) {
    left_.target = pending_.front().left;
    right_.target = pending_.front().right;
    pending_.pop_front();
  }
  MoveWheels(static_cast<double>(kStepUs) * 1e-6);
  if (RobotMs() * config_.gyro_rate_hz * 1e-3 >= static_cast<double>(gyro_samples_ + 1)) {
    SampleGyro();
  }
  if (RobotMs() >= next_frame_ms_) MakeFrame();
  ServeAdapter();
}

void Emulator::MoveWheels(double dt) {
  const double before_left = left_.way;
  const double before_right = right_.way;
  for (Wheel* wheel : {&left_, &right_}) {
    const double blend = config_.lag_s <= 0 ? 1 : 1 - std::exp(-dt / config_.lag_s);
    wheel->speed += blend * (wheel->target + wheel->pushed - wheel->speed);
    if (std::abs(wheel->speed) < 1e-5 && wheel->target == 0) wheel->speed = wheel->pushed;
    wheel->way += wheel->speed * dt;
  }
  const double left = left_.way - before_left;
  const double right = right_.way - before_right;
  const double turn = (right - left) / kTrackM;
  x_ += (left + right) / 2 * std::cos(yaw_ + turn / 2);
  y_ += (left + right) / 2 * std::sin(yaw_ + turn / 2);
  yaw_ += turn;
}

void Emulator::Obey(const Commands& commands) {
  if (commands.drive) {
    commanded_ = ToTwist(*commands.drive, kTrackM);
    const double turn = commanded_.w_rad_s * kTrackM / 2;
    pending_.push_back({now_ + DurationFromSeconds(config_.dead_time_s), commanded_.v_m_s - turn,
                        commanded_.v_m_s + turn});
    ++commands_;
    last_command_ = now_;
  }
  if (commands.request) requested_ |= *commands.request;
  if (commands.output) output_ = *commands.output;
  if (commands.set_gains) gains_ = *commands.set_gains;
  gains_requested_ |= commands.get_gains;
}

void Emulator::SampleGyro() {
  ++gyro_samples_;
  const std::array<double, 3> w{0, 0, w_rad_s()};
  gyro_truth_.push_back({now_, w});
  // The sensor sits turned by 90 degrees: raw x is the robot's y, raw y its -x.
  const std::array<double, 3> raw{w[1] / kLsb, -w[0] / kLsb, w[2] / kLsb};
  std::array<int16_t, 3> sample{};
  for (size_t i = 0; i < 3; ++i) {
    sample[i] =
        Saturate(raw[i] + config_.gyro_bias_lsb[i] + config_.gyro_noise_lsb * rng_.Normal());
  }
  if (gyro_queue_.samples.size() < kMaxGyroSamples) gyro_queue_.samples.push_back(sample);
}

void Emulator::MakeFrame() {
  ++next_frame_;
  const double jitter_ms = static_cast<double>(config_.frame_jitter.us) * 1e-3;
  next_frame_ms_ = 20.0 * static_cast<double>(next_frame_) + rng_.Uniform(-jitter_ms, jitter_ms);
  Feedback f;
  BasicData basic;
  basic.timestamp_ms =
      static_cast<uint16_t>(config_.first_timestamp_ms + static_cast<int64_t>(RobotMs()));
  if (rng_.Uniform() < config_.duplicate_timestamp) basic.timestamp_ms = last_timestamp_ms_;
  last_timestamp_ms_ = basic.timestamp_ms;
  basic.bumper = bumper_;
  basic.wheel_drop = wheel_drop_;
  basic.cliff = cliff_;
  basic.left_encoder = Ticks(left_, config_.first_left_ticks);
  basic.right_encoder = Ticks(right_, config_.first_right_ticks);
  basic.left_pwm = static_cast<int8_t>(std::clamp(left_.target * 150, -100.0, 100.0));
  basic.right_pwm = static_cast<int8_t>(std::clamp(right_.target * 150, -100.0, 100.0));
  basic.charger = config_.charger;
  basic.battery_dv = config_.battery_dv;
  basic.over_current = over_current_;
  frames_.push_back(
      {now_, basic.timestamp_ms, basic.left_encoder, basic.right_encoder, x_, y_, yaw_});
  f.basic = basic;
  f.docking_ir = DockingIr{};
  const double degrees = (yaw_ - heading_zero_) * 180 / std::numbers::pi;
  f.inertial = Inertial{Saturate(100 * (degrees - 360 * std::round(degrees / 360))),
                        Saturate(100 * w_rad_s() * 180 / std::numbers::pi)};
  f.cliff = CliffAdc{1700, 1900, 1650};
  f.current = MotorCurrent{};
  if (!gyro_queue_.samples.empty()) {
    f.raw_gyro = gyro_queue_;
    gyro_queue_.first_id = static_cast<uint8_t>(gyro_queue_.first_id +
                                                static_cast<uint8_t>(gyro_queue_.samples.size()));
    gyro_queue_.samples.clear();
  }
  f.gp_input = GpInput{0, {4095, 4095, 4095, 4095}};

  Feedback answers;
  if ((requested_ & kRequestHardwareVersion) != 0) answers.hardware = config_.hardware;
  if ((requested_ & kRequestFirmwareVersion) != 0) answers.firmware = config_.firmware;
  if ((requested_ & kRequestUdid) != 0) answers.udid = config_.udid;
  if (gains_requested_) answers.controller = gains_;
  requested_ = 0;
  gains_requested_ = false;

  std::vector<uint8_t> payload = EncodeFeedback(f);
  if (rng_.Uniform() < config_.unknown_sub_payload) {
    payload.insert(payload.end(), {18, 4, 0xAA, 0x55, 0x03, 0x01});
  }
  const std::vector<uint8_t> extra = EncodeFeedback(answers, config_.version_form);
  if (!config_.answers_in_own_frame) payload.insert(payload.end(), extra.begin(), extra.end());
  PutOnLine(EncodeFrame(payload));
  if (config_.answers_in_own_frame && !extra.empty()) PutOnLine(EncodeFrame(extra));
}

void Emulator::PutOnLine(const std::vector<uint8_t>& frame) {
  if (silent_) return;
  std::vector<uint8_t> bytes;
  if (rng_.Uniform() < config_.garbage_burst) {
    const uint32_t n = rng_.Below(100);
    for (uint32_t i = 0; i < n; ++i) bytes.push_back(static_cast<uint8_t>(rng_.Below(256)));
  }
  bytes.insert(bytes.end(), frame.begin(), frame.end());
  Utime begin = std::max(now_ + config_.transport_delay, line_free_);
  double offset_us = 0;
  for (uint8_t byte : bytes) {
    offset_us += kByteUs;
    if (rng_.Uniform() < config_.drop_byte) continue;
    if (rng_.Uniform() < config_.flip_bit) byte ^= static_cast<uint8_t>(1 << rng_.Below(8));
    line_.push_back({begin + DurationUs{std::llround(offset_us)}, byte});
  }
  line_free_ = begin + DurationUs{std::llround(offset_us)};
}

// A packet leaves when it is full, or when the latency timer has run since the packet before. The
// host polls the adapter every millisecond, which its jitter stands for.
void Emulator::ServeAdapter() {
  const auto flush = [this](Utime at) {
    Deliver(std::move(packet_), at);
    packet_.clear();
    packet_since_ = at;
  };
  while (true) {
    const Utime timer = packet_since_ + config_.latency_timer;
    const bool byte_next = !line_.empty() && line_.front().at <= now_ &&
                           (line_.front().at <= timer || packet_.empty());
    if (byte_next) {
      // An idle adapter sends empty packets in step with its timer.
      if (packet_.empty() && config_.latency_timer.us > 0) {
        const int64_t idle = (line_.front().at - packet_since_).us / config_.latency_timer.us;
        packet_since_ = packet_since_ + DurationUs{idle * config_.latency_timer.us};
      }
      packet_.push_back(line_.front().value);
      const Utime at = line_.front().at;
      line_.pop_front();
      if (packet_.size() == kUsbPacket) flush(at);
    } else if (!packet_.empty() && timer <= now_) {
      flush(std::max(timer, packet_since_));
    } else {
      return;
    }
  }
}

void Emulator::Deliver(std::vector<uint8_t> bytes, Utime at) {
  if (at >= stall_until_ && config_.stall_rate_hz > 0 &&
      rng_.Uniform() < config_.stall_rate_hz * 0.02) {
    stall_until_ = at + config_.stall;
  }
  const double jitter = -static_cast<double>(config_.host_jitter.us) * std::log(1 - rng_.Uniform());
  at = std::max({at + DurationUs{std::llround(jitter)}, stall_until_, last_delivery_});
  // Packets that wait together are read together.
  if (!deliveries_.empty() && deliveries_.back().at == at) {
    auto& last = deliveries_.back().bytes;
    last.insert(last.end(), bytes.begin(), bytes.end());
  } else {
    deliveries_.push_back({at, std::move(bytes)});
  }
  last_delivery_ = at;
}

}  // namespace gw::kobuki

// The driver core and an emulated base, joined in virtual time. For tests.
#pragma once

#include <cstdlib>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/kobuki/core/driver.h"
#include "test/emulators/kobuki/emulator.h"

namespace gw::kobuki {

class DriverRig {
 public:
  explicit DriverRig(const EmulatorConfig& robot = {}, const KobukiConfig& config = {},
                     const WheelCalibration& geometry = {})
      : driver(config, geometry), emulator(robot), now_(robot.start) {
    driver.PortOpened(now_);
  }

  // Runs for a time; every 50 ms `command` gives what to drive, or nothing.
  using Commander = std::function<std::optional<Twist>(Utime)>;
  void Run(double seconds, const Commander& command = nullptr) {
    const Utime end = now_ + DurationFromSeconds(seconds);
    while (now_ < end) {
      now_ = now_ + Milliseconds(1);
      for (const auto& delivery : emulator.AdvanceTo(now_)) {
        const Driver::Samples samples = driver.Receive(delivery.bytes, delivery.at);
        wheel.insert(wheel.end(), samples.wheel.begin(), samples.wheel.end());
        imu.insert(imu.end(), samples.imu.begin(), samples.imu.end());
      }
      if (command && now_.us % 50'000 == 0) {
        if (const auto twist = command(now_)) {
          driver.Command({now_, ++command_seq_, twist->v_m_s, twist->w_rad_s}, now_);
        }
      }
      if (now_.us % 5'000 == 0) {
        const auto bytes = driver.Tick(now_);
        if (!bytes.empty() && connected) emulator.Write(bytes, now_);
      }
    }
  }
  void Run(double seconds, Twist twist) {
    Run(seconds, [twist](Utime) { return twist; });
  }

  // The time of the sample minus the true time of its measurement, which is told by ticks and
  // nearest time; `expected` is the constant delay to look behind. Only for a base that moves.
  std::optional<DurationUs> TimeError(const WheelSample& sample, DurationUs expected) const {
    std::optional<DurationUs> best;
    for (const auto& truth : emulator.frames()) {
      if (truth.left_ticks != sample.left_ticks || truth.right_ticks != sample.right_ticks)
        continue;
      const DurationUs error = sample.utime - truth.measured - expected;
      if (!best || std::abs(error.us) < std::abs(best->us)) best = error;
    }
    return best;
  }

  int64_t Counter(const std::string& name) const {
    for (const auto& [key, value] : driver.Counters()) {
      if (key == "kobuki." + name) return value;
    }
    return -1;
  }
  Utime now() const { return now_; }

  Driver driver;
  Emulator emulator;
  std::vector<WheelSample> wheel;
  std::vector<ImuSample> imu;
  bool connected = true;  // false when commands do not reach the base

 private:
  Utime now_;
  int64_t command_seq_ = 0;
};

}  // namespace gw::kobuki

// What every process of ours is around its core: command line, configuration, bus, loop, HEALTH,
// watchdog, and the one place that catches exceptions.
//
//   int main(argc, argv) { return RunProgram(argc, argv, {"gw-frontend", "..."}, MakeNode); }
//
// Exit codes: common/core/exit_code.h.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/config/robot_config.h"
#include "common/process/bus.h"
#include "common/process/clock.h"
#include "common/process/health_reporter.h"
#include "common/process/log_line.h"
#include "common/process/loop.h"
#include "common/process/sequence_monitor.h"
#include "common/wire/wire.h"

namespace gw::process {

// What a node may use of its process.
class Shell {
 public:
  Shell(Bus* bus, Loop* loop, const Clock* clock, HealthReporter health)
      : bus_(bus), loop_(loop), clock_(clock), health_(std::move(health)) {}

  Utime Now() const { return clock_->Now(); }
  HealthReporter& health() { return health_; }
  LogLine& log() { return log_; }
  Loop& loop() { return *loop_; }

  // Decodes every message of the channel. What cannot be decoded, and what is missing by seq, is
  // counted as CHANNEL.undecodable and CHANNEL.lost.
  template <typename T>
  Result<Done> Listen(const std::string& channel, std::function<void(T, Utime received)> handler) {
    return ListenRaw(channel, [this, channel, handler = std::move(handler)](
                                  std::span<const uint8_t> bytes, Utime received) {
      Result<T> message = wire::Decode<T>(bytes);
      if (!message) {
        CountUndecodable(channel, message.error());
        return;
      }
      handler(std::move(*message), received);
    });
  }
  Result<Done> ListenRaw(const std::string& channel, Bus::Handler handler);
  void CountUndecodable(const std::string& channel, const Error& error);

  // A message that cannot be sent is counted as CHANNEL.unsent and logged.
  void Publish(const std::string& channel, std::span<const uint8_t> message);

  // For programs that have an end of their own: the program ends after this step.
  void End(int exit_code) { exit_code_ = exit_code; }
  const std::optional<int>& exit_code() const { return exit_code_; }

 private:
  Bus* bus_;
  Loop* loop_;
  const Clock* clock_;
  HealthReporter health_;
  LogLine log_;
  SequenceMonitor sequence_;
  std::optional<int> exit_code_;
};

// A core with its subscriptions.
class Node {
 public:
  virtual ~Node() = default;
  // Subscribes; opens what it needs.
  virtual Result<Done> Start(Shell& shell) = 0;
  // After every batch of messages and every tick (kTick). False: there is more to do at once; the
  // shell takes in messages and calls again.
  virtual bool Step(Shell& shell) = 0;
  // Before the process ends: finish, flush.
  virtual void Stop(Shell& /*shell*/) {}
};

inline constexpr DurationUs kTick = Milliseconds(20);

struct ProgramDescription {
  std::string name;
  std::string text;  // for --help
};

// An option of a single program, beyond --config, --lcm-url and --check.
struct ProgramOption {
  std::string name;                               // "--map"
  std::variant<std::string*, int*, bool*> value;  // bool: a flag
  std::string text;                               // for --help
  bool required = false;
};

using MakeNode = std::function<Result<std::unique_ptr<Node>>(const RobotConfig& config)>;

int RunProgram(int argc, char** argv, const ProgramDescription& program,
               const std::vector<ProgramOption>& options, const MakeNode& make_node);

}  // namespace gw::process

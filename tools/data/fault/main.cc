// gw-fault: what can go wrong with sensors, put into a log that was good.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <string>

#include "common/cli/command.h"
#include "common/config/loader.h"
#include "common/core/exit_code.h"
#include "tools/data/fault/apply_faults.h"
#include "tools/data/files/json.h"

namespace gw::fault {
namespace {

int Fail(const Error& error) {
  std::fprintf(stderr, "gw-fault: %s\n", error.message.c_str());
  return ExitCodeFor(error);
}

// Says how far it is, every two seconds.
class ProgressLine {
 public:
  void operator()(int64_t done, int64_t total) {
    const auto now = Clock::now();
    if (now - last_ < std::chrono::seconds(2)) return;
    last_ = now;
    std::fprintf(stderr, "gw-fault: %lld of %lld MB\n", static_cast<long long>(done / 1000000),
                 static_cast<long long>(total / 1000000));
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

void Print(const FaultSummary& s, const std::string& out, bool json) {
  const std::pair<const char*, int64_t> values[] = {
      {"events", s.events},
      {"bytes", s.bytes},
      {"black_frames", s.black_frames},
      {"frozen_frames", s.frozen_frames},
      {"blurred_frames", s.blurred_frames},
      {"dropped_frames", s.dropped_frames},
      {"delayed_messages", s.delayed},
      {"slipped_messages", s.slipped},
      {"biased_messages", s.biased},
      {"teleported_messages", s.teleported},
      {"named_fault_messages", s.named},
      {"estimates_left_out", s.left_out},
      {"undecodable", s.undecodable},
  };
  tools::Json report = {{"log", out}};
  std::string text = out + "\n";
  for (const auto& [name, value] : values) {
    report[name] = value;
    if (value != 0) text += fmt::format("  {:<20} {}\n", name, value);
  }
  fmt::print("{}", json ? tools::JsonLine(report) : text);
}

// Help on --fault: a line for each.
std::string FaultList() {
  std::string out = "Faults (--fault):\n";
  for (const FaultKind& kind : FaultKinds()) {
    out += fmt::format("  {:<18} {}\n", kind.name, kind.text);
  }
  return out + "wheels_*: of WHEEL and, but for wheels_resampled, of DR messages.";
}

int Main(int argc, char** argv) {
  cli::Command app(
      "Puts sensor faults into a log. Times are seconds from the begin of the input log; an empty\n"
      "T0 or T1 is its begin or end; every option but --gyro-bias and --seed may be given more\n"
      "than once. Each edit is noted in the log.\n"
      "Exit: 0 ok, 1 log not readable or writable, 2 usage.");
  std::string in, out, config;
  FaultArguments a;
  bool json = false;
  app.AddOption("IN", in, "LCM log")->Required();
  app.AddOption("OUT", out, "LCM log to write")->Required();
  app.AddOption("--black", a.black, "T0:T1  images black, no depth");
  app.AddOption("--freeze", a.freeze, "T0:T1  the last image before T0 again and again");
  app.AddOption("--blur", a.blur, "T0:T1:SIGMA  Gaussian blur of the grey images, px");
  app.AddOption("--drop", a.drop, "T0:T1[:P]  camera messages lost, each with probability P (1)");
  app.AddOption("--delay", a.delay, "CHANNEL:MS  received later than measured");
  app.AddOption("--slip", a.slip, "T0:T1:FACTOR  wheels measure FACTOR times the way (and DR)");
  app.AddOption("--gyro-bias", a.gyro_bias_rad_s, "RAD_S  added on each axis of the gyro");
  app.AddOption("--teleport", a.teleport,
                "T0:T1  the robot is carried away without noticing: the span is cut out, DR and "
                "wheels continue");
  app.AddOption("--fault", a.fault,
                "NAME[:T0:T1]  a fault of the list below; over the whole log, or when it usually "
                "happens, unless a span is given");
  app.AddOption("--config", config,
                "robot YAML: focal length, baseline and depth unit for dots and person "
                "(RealSense D435)");
  app.AddOption("--seed", a.seed, "of --drop (1)");
  app.Footer(FaultList());
  app.AddFlag("--json", json, "print the summary as JSON");
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  Result<FaultPlan> plan = ParseFaultPlan(a);
  if (!plan) return Fail(plan.error());
  if (!config.empty()) {
    const auto robot = LoadRobotConfig(config);
    if (!robot) return Fail(robot.error());
    plan->optics = OpticsOf(robot->calibration.camera);
  }
  const Result<FaultSummary> summary = ApplyFaults(in, *plan, out, ProgressLine());
  if (!summary) return Fail(summary.error());
  Print(*summary, out, json);
  return kExitOk;
}

}  // namespace
}  // namespace gw::fault

int main(int argc, char** argv) {
  return gw::fault::Main(argc, argv);
}

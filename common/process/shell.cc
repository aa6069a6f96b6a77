#include "common/process/shell.h"

#include <cstdio>
#include <exception>

#include "common/cli/command.h"
#include "common/config/loader.h"
#include "common/config/writer.h"
#include "common/core/exit_code.h"
#include "common/core/version.h"
#include "common/process/sd_notify.h"
#include "common/wire/channels.h"

namespace gw::process {
namespace {

int Fail(const std::string& program, const Error& error) {
  std::fprintf(stderr, "<3>%s: %s\n", program.c_str(), error.message.c_str());
  return ExitCodeFor(error);
}

void AddOption(cli::Command& app, const ProgramOption& option) {
  cli::Option* added = nullptr;
  if (bool* const* flag = std::get_if<bool*>(&option.value)) {
    added = app.AddFlag(option.name, **flag, option.text);
  } else if (int* const* number = std::get_if<int*>(&option.value)) {
    added = app.AddOption(option.name, **number, option.text);
  } else {
    added = app.AddOption(option.name, *std::get<std::string*>(option.value), option.text);
  }
  added->Required(option.required);
}

// One round: wait, take in messages, let the node work until it has nothing more to do.
Result<bool> Round(Loop& loop, Bus& bus, Node& node, Shell& shell) {
  const auto ready = loop.Wait();
  if (!ready) return ready.error();
  bool done = false;
  while (!done) {
    const auto pumped = bus.Pump(0);
    if (!pumped) return pumped.error();
    done = node.Step(shell);
  }
  if (const auto health = shell.health().ReportIfDue(shell.Now())) {
    shell.Publish(wire::kHealth, wire::Encode(*health));
  }
  return !ready->stop && !shell.exit_code();
}

// What a core or a library throws costs that step, not the process; a step that keeps throwing does
// not ping the watchdog.
Result<Done> RunLoop(Loop& loop, Bus& bus, Node& node, Shell& shell) {
  const SdNotify systemd;
  systemd.Ready();
  while (true) {
    try {
      const auto going_on = Round(loop, bus, node, shell);
      if (!going_on) return going_on.error();
      if (!*going_on) break;
      systemd.Watchdog();
    } catch (const std::exception& error) {
      shell.health().Count("exceptions");
      shell.log().Write(shell.Now(), Severity::kError, "exception",
                        {{"what", error.what()}, {"action", "report this with the log"}});
    }
  }
  systemd.Stopping();
  node.Stop(shell);
  return Done{};
}

}  // namespace

Result<Done> Shell::ListenRaw(const std::string& channel, Bus::Handler handler) {
  return bus_->Subscribe(channel, [this, channel, handler = std::move(handler)](
                                      std::span<const uint8_t> bytes, Utime received) {
    // Reliable channels count their own losses, and their seq is that of the delivery. On HEALTH
    // every process counts for itself.
    const wire::Channel* entry = wire::FindChannel(channel);
    const auto header = wire::ReadHeader(bytes);
    if (header && entry != nullptr && entry->policy != wire::QueuePolicy::kReliable &&
        channel != wire::kHealth) {
      const int64_t lost = sequence_.Observe(channel, "", header->seq);
      if (lost > 0) health_.Count(channel + ".lost", lost);
    }
    handler(bytes, received);
  });
}

void Shell::CountUndecodable(const std::string& channel, const Error& error) {
  health_.CountUndecodable(channel, error.message);
  log_.Write(Now(), Severity::kWarning, channel + ".undecodable",
             {{"what", error.message},
              {"action", "check who sends it, and that all processes are of one version"}});
}

void Shell::Publish(const std::string& channel, std::span<const uint8_t> message) {
  const auto sent = bus_->Publish(channel, message);
  if (sent) return;
  health_.Count(channel + ".unsent");
  log_.Write(Now(), Severity::kError, channel + ".unsent",
             {{"what", sent.error().message}, {"action", "check the multicast route"}});
}

int RunProgram(int argc, char** argv, const ProgramDescription& program,
               const std::vector<ProgramOption>& options, const MakeNode& make_node) {
  std::string config_path;
  std::string lcm_url;
  bool check = false;
  cli::Command app(program.text + "\nExit: 0 ok, 1 failed, 2 usage, 78 bad configuration.",
                   program.name);
  app.AddOption("--config", config_path, "robot YAML")->Required();
  app.AddOption("--lcm-url", lcm_url, "bus, instead of process.lcm_url of the configuration");
  app.AddFlag("--check", check, "check the configuration and exit");
  for (const ProgramOption& o : options) AddOption(app, o);
  if (const auto exit = app.Parse(argc, argv)) return *exit;

  const Result<RobotConfig> config = LoadRobotConfig(config_path);
  if (!config) return Fail(program.name, config.error());
  auto loop = Loop::Create(kTick);  // before any other thread, so that signals come to us
  if (!loop) return Fail(program.name, loop.error());
  auto node = make_node(*config);
  if (!node) return Fail(program.name, node.error());
  if (check) return kExitOk;
  auto bus = LiveBus::Create(lcm_url.empty() ? config->process.lcm_url : lcm_url);
  if (!bus) return Fail(program.name, bus.error());
  const Clock clock;
  Shell shell(bus->get(), &*loop, &clock,
              HealthReporter(program.name, Version(), ConfigHash(*config)));
  if (!(*bus)->warning().empty()) {
    std::fprintf(stderr, "<4>%s: %s\n", program.name.c_str(), (*bus)->warning().c_str());
  }
  shell.health().SetState(HealthState::kStarting);
  if (const auto started = (*node)->Start(shell); !started) {
    return Fail(program.name, started.error());
  }
  loop->Watch((*bus)->fd());
  if (const auto ended = RunLoop(*loop, **bus, **node, shell); !ended) {
    return Fail(program.name, ended.error());
  }
  return shell.exit_code().value_or(kExitOk);
}

}  // namespace gw::process

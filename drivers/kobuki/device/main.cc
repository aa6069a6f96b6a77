// gw-kobuki: the Kobuki base on the bus.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>

#include "common/cli/command.h"
#include "common/config/loader.h"
#include "common/core/exit_code.h"
#include "common/process/bus.h"
#include "common/process/clock.h"
#include "common/process/loop.h"
#include "common/process/sd_notify.h"
#include "drivers/kobuki/device/kobuki_node.h"

namespace gw::kobuki {
namespace {

constexpr DurationUs kTick = Milliseconds(5);
// The option --check watches for the length of two requests for the version, which is shorter than
// the link's patience with a silent port.
constexpr DurationUs kCheckFor = Link::kGiveUp;

int Fail(const Error& error) {
  std::fprintf(stderr, "gw-kobuki: %s\n", error.message.c_str());
  return ExitCodeFor(error);
}

// Waits for the port and the tick, and serves the node. Gives false when the signal to stop came.
Result<bool> Step(process::Loop* loop, process::Bus* bus, KobukiNode* node, int* watched) {
  if (node->port_fd() != *watched) {
    if (*watched >= 0) loop->Unwatch(*watched);
    *watched = node->port_fd();
    if (*watched >= 0) loop->Watch(*watched);
  }
  const auto ready = loop->Wait();
  if (!ready) return ready.error();
  const auto is_ready = [&](int fd) {
    return std::find(ready->fds.begin(), ready->fds.end(), fd) != ready->fds.end();
  };
  if (*watched >= 0 && is_ready(*watched)) node->ReadPort();
  if (bus != nullptr && is_ready(bus->fd())) {
    if (const auto pumped = bus->Pump(0); !pumped) return pumped.error();
  }
  if (ready->tick) node->Tick();
  return !ready->stop;
}

// The option --check: says whether there is a base, and which one.
int Check(process::Loop* loop, KobukiNode* node, const process::Clock& clock) {
  const Utime end = clock.Now() + kCheckFor;
  int watched = -1;
  node->Tick();
  // A port that cannot be opened now will not come by waiting.
  if (node->link_state() != LinkState::kAbsent) {
    while (clock.Now() < end && !node->driver().identity().complete()) {
      const auto going_on = Step(loop, nullptr, node, &watched);
      if (!going_on) return Fail(going_on.error());
      if (!*going_on || node->link_state() == LinkState::kAbsent) break;
    }
  }
  const Identity& id = node->driver().identity();
  if (node->link_state() != LinkState::kTalking || !id.firmware || !id.hardware) {
    const std::string message = node->LinkMessage();
    std::fprintf(stderr, "gw-kobuki: %s\n",
                 message.empty() ? "the base does not tell its version" : message.c_str());
    return kExitFailed;
  }
  const Condition condition = node->driver().GetCondition(clock.Now());
  std::printf("%s: Kobuki, hardware %d.%d.%d, firmware %d.%d.%d, %.1f V\n",
              node->port_path().c_str(), id.hardware->major, id.hardware->minor, id.hardware->patch,
              id.firmware->major, id.firmware->minor, id.firmware->patch,
              node->driver().battery().volts);
  if (!condition.message.empty()) std::printf("%s\n", condition.message.c_str());
  return condition.state == HealthState::kFailed ? kExitFailed : kExitOk;
}

int Run(const RobotConfig& config, const std::string& lcm_url, bool check) {
  // The loop is made first, so that no other thread takes the signals.
  auto loop = process::Loop::Create(kTick);
  if (!loop) return Fail(loop.error());
  const process::Clock clock;
  const auto now = [&clock] { return clock.Now(); };
  if (check) {
    const auto quiet = [](const std::string&) {};
    KobukiNode node(config, nullptr, now, process::LogLine(Milliseconds(1000), quiet));
    return Check(&*loop, &node, clock);
  }
  auto bus = process::LiveBus::Create(lcm_url);
  if (!bus) return Fail(bus.error());
  KobukiNode node(config, bus->get(), now, process::LogLine());
  if (const auto started = node.Start(); !started) return Fail(started.error());
  loop->Watch((*bus)->fd());
  const process::SdNotify systemd;
  systemd.Ready();
  int watched = -1;
  while (true) {
    const auto going_on = Step(&*loop, bus->get(), &node, &watched);
    if (!going_on) return Fail(going_on.error());  // the node's destructor stops the base
    if (!*going_on) break;
    systemd.Watchdog();
  }
  systemd.Stopping();
  node.Shutdown();
  return kExitOk;
}

int Main(int argc, char** argv) {
  std::string config_path;
  std::string lcm_url;
  bool check = false;
  cli::Command app(
      "Driver of the Kobuki base: publishes WHEEL (and IMU, if configured), obeys BASE_COMMAND.\n"
      "Exit: 0 ok, 1 failed (with --check: no base, no permission, silent, another device), 2 "
      "usage,"
      "\n78 bad configuration.");
  app.AddOption("--config", config_path, "YAML of the robot")->Required();
  app.AddOption("--lcm-url", lcm_url, "bus, instead of process.lcm_url of the configuration");
  app.AddFlag("--check", check, "check configuration and base, say what is there, and exit");
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  const auto config = LoadRobotConfig(config_path);
  if (!config) return Fail(config.error());
  try {
    return Run(*config, lcm_url.empty() ? config->process.lcm_url : lcm_url, check);
  } catch (const std::exception& e) {
    return Fail({ErrorCode::kIo, e.what()});
  }
}

}  // namespace
}  // namespace gw::kobuki

int main(int argc, char** argv) {
  return gw::kobuki::Main(argc, argv);
}

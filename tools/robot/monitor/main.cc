// gw-monitor: watches the processes on the bus until SIGINT or SIGTERM, then writes what it saw.
#include <cstdio>
#include <string>

#include "common/cli/command.h"
#include "common/core/exit_code.h"
#include "common/process/bus.h"
#include "common/process/loop.h"
#include "tools/robot/monitor/monitor.h"

namespace gw::tools {
namespace {

constexpr int kTicksPerLine = 4;

int Fail(const Error& error) {
  std::fprintf(stderr, "gw-monitor: %s\n", error.message.c_str());
  return ExitCodeFor(error);
}

int Run(const std::string& url, const std::string& folder) {
  auto loop = process::Loop::Create(Milliseconds(500));
  if (!loop) return Fail(loop.error());
  auto bus = process::LiveBus::Create(url);
  if (!bus) return Fail(bus.error());
  if (!(*bus)->warning().empty()) {
    std::fprintf(stderr, "gw-monitor: %s\n", (*bus)->warning().c_str());
  }
  Monitor monitor;
  if (const auto attached = Monitor::Attach(**bus, monitor); !attached)
    return Fail(attached.error());
  loop->Watch((*bus)->fd());
  for (int ticks = 0;;) {
    const auto ready = loop->Wait();
    if (!ready) return Fail(ready.error());
    if (const auto pumped = (*bus)->Pump(0); !pumped) return Fail(pumped.error());
    if (ready->tick && ++ticks % kTicksPerLine == 0) {
      std::fprintf(stderr, "gw-monitor: %s\n", monitor.StatusLine().c_str());
    }
    if (ready->stop) break;
  }
  std::printf("%s\n", monitor.StatusLine().c_str());
  if (folder.empty()) return kExitOk;
  const auto written = monitor.Write(folder);
  return written ? kExitOk : Fail(written.error());
}

}  // namespace
}  // namespace gw::tools

int main(int argc, char** argv) {
  std::string url = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304";
  std::string folder;
  gw::cli::Command app(
      "Watches a running system: poses, latency, losses, health. Ends with SIGINT.");
  app.AddOption("--lcm-url", url, "bus");
  app.AddOption(
      "--out", folder,
      "folder for trajectory.tum, frames.csv, pose_times.csv, health.csv, ground_truth.tum");
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  return gw::tools::Run(url, folder);
}

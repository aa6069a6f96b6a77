// gw-kobuki-emulator: a Kobuki base on a pseudo terminal, for trying gw-kobuki without a robot.
#include <signal.h>

#include <cstdio>
#include <string>

#include "common/cli/command.h"
#include "common/core/exit_code.h"
#include "test/emulators/kobuki/pty_base.h"

int main(int argc, char** argv) {
  gw::kobuki::EmulatorConfig config;
  std::string link = "/tmp/kobuki";
  int latency_ms = 1;
  int delay_ms = 0;
  gw::cli::Command app(
      "A Kobuki base on a pseudo terminal. Commands on standard input: unplug, plug, silent, "
      "talk,\n"
      "reboot, bumper, cliff, drop, clear, where, quit.");
  app.AddOption("--link", link, "symbolic link to the terminal, to be given to the driver");
  app.AddOption("--seed", config.seed, "of noise and faults");
  app.AddOption("--latency-timer", latency_ms, "of the USB adapter, ms")->InRange(0, 255);
  app.AddOption("--transport-delay", delay_ms, "from measurement to the line, ms")
      ->InRange(0, 1000);
  app.AddOption("--drop-byte", config.drop_byte, "probability per byte")->InRange(0., 1.);
  app.AddOption("--flip-bit", config.flip_bit, "probability per byte")->InRange(0., 1.);
  app.AddOption("--garbage", config.garbage_burst, "probability of noise before a frame")
      ->InRange(0., 1.);
  app.AddOption("--stall-rate", config.stall_rate_hz, "how often the host sleeps for 60 ms, Hz")
      ->InRange(0., 10.);
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  config.latency_timer = gw::Milliseconds(latency_ms);
  config.transport_delay = gw::Milliseconds(delay_ms);

  sigset_t stop;
  sigemptyset(&stop);
  sigaddset(&stop, SIGINT);
  sigaddset(&stop, SIGTERM);
  ::pthread_sigmask(SIG_BLOCK, &stop, nullptr);  // the signals are blocked in the base's thread too
  auto base = gw::kobuki::PtyBase::Create(config, link);
  if (!base) {
    std::fprintf(stderr, "gw-kobuki-emulator: %s\n", base.error().message.c_str());
    return gw::ExitCodeFor(base.error());
  }
  std::printf("%s\n", link.c_str());
  std::fflush(stdout);
  gw::kobuki::PtyBase& b = **base;
  const auto contact = [&b](uint8_t bumper, uint8_t drop, uint8_t cliff) {
    b.With([=](auto& robot) { robot.SetContact(bumper, drop, cliff); });
  };
  char word[32];
  while (std::scanf("%31s", word) == 1) {
    const std::string command = word;
    if (command == "quit") return gw::kExitOk;
    if (command == "unplug") b.Unplug();
    if (command == "plug" && !b.Plug()) std::fprintf(stderr, "cannot plug in again\n");
    if (command == "silent") b.With([](auto& robot) { robot.SetSilent(true); });
    if (command == "talk") b.With([](auto& robot) { robot.SetSilent(false); });
    if (command == "reboot") b.With([](auto& robot) { robot.Reboot(); });
    if (command == "bumper") contact(gw::kobuki::kCentreBit, 0, 0);
    if (command == "drop") contact(0, gw::kobuki::kLeftWheelDropBit, 0);
    if (command == "cliff") contact(0, 0, gw::kobuki::kCentreBit);
    if (command == "clear") contact(0, 0, 0);
    if (command == "where") {
      b.With([](auto& robot) {
        std::printf("x %.3f m, y %.3f m, yaw %.3f rad, v %.3f m/s, w %.3f rad/s\n", robot.x_m(),
                    robot.y_m(), robot.yaw_rad(), robot.v_m_s(), robot.w_rad_s());
      });
      std::fflush(stdout);
    }
  }
  int signal = 0;
  ::sigwait(&stop, &signal);  // standard input is closed: the emulator runs until a signal comes
  return gw::kExitOk;
}

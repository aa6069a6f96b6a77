// Tells systemd how the process is doing (Type=notify, WatchdogSec=). Without systemd, nothing.
// Protocol: sd_notify(3), a datagram to $NOTIFY_SOCKET.
#pragma once

#include <string>
#include <string_view>

namespace gw::process {

class SdNotify {
 public:
  // Reads $NOTIFY_SOCKET.
  SdNotify();

  bool active() const { return !socket_path_.empty(); }
  void Ready() const { Send("READY=1"); }
  // Only from the main loop, and only while work progresses: it is what keeps the process alive.
  void Watchdog() const { Send("WATCHDOG=1"); }
  void Stopping() const { Send("STOPPING=1"); }

 private:
  void Send(std::string_view state) const;

  std::string socket_path_;
};

}  // namespace gw::process

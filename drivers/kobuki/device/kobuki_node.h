// The program gw-kobuki without its main(): the driver core on a serial port and a bus.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "common/config/robot_config.h"
#include "common/process/bus.h"
#include "common/process/health_reporter.h"
#include "common/process/log_line.h"
#include "drivers/kobuki/core/driver.h"
#include "drivers/kobuki/device/find_port.h"
#include "drivers/kobuki/device/link.h"
#include "drivers/kobuki/device/serial_port.h"

namespace gw::kobuki {

class KobukiNode {
 public:
  using Now = std::function<Utime()>;

  // `bus` must outlive the node; it is null for --check, which publishes nothing.
  KobukiNode(const RobotConfig& config, process::Bus* bus, Now now, process::LogLine log);
  // Tells the base to stop.
  ~KobukiNode();
  KobukiNode(const KobukiNode&) = delete;
  KobukiNode& operator=(const KobukiNode&) = delete;

  // Subscribes to the commands. Errors are those of the bus.
  Result<Done> Start();

  // To be called when port_fd() is readable.
  void ReadPort();
  // To be called every 5 ms: opens and reopens the port, sends commands, publishes HEALTH.
  void Tick();
  // Stops the base, waits until it is told, closes the port.
  void Shutdown();

  int port_fd() const { return port_ ? port_->fd() : -1; }  // -1 while none is open
  LinkState link_state() const { return link_.state(now_()); }
  // What is wrong with the link, for people; empty while all is well.
  std::string LinkMessage() const;
  const Driver& driver() const { return driver_; }
  const std::string& port_path() const { return port_path_; }

 private:
  void OpenPort();
  void ClosePort();
  void Send(const std::vector<uint8_t>& bytes);
  void Publish(const Driver::Samples& samples);
  void PublishHealth();
  void UpdateHealth();
  void Publish(const char* channel, const std::vector<uint8_t>& message);

  RobotConfig config_;
  process::Bus* bus_;
  Now now_;
  process::LogLine log_;
  process::HealthReporter health_;
  Driver driver_;
  Link link_;
  std::optional<SerialPort> port_;
  std::string port_path_;
  std::string open_error_;
  LinkState logged_state_ = LinkState::kAbsent;
};

}  // namespace gw::kobuki

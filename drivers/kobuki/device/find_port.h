// Finds the serial port of the base.
#pragma once

#include <string>

#include "common/core/result.h"

namespace gw::kobuki {

// The folders in which the system keeps devices; tests make their own.
struct SystemRoots {
  std::string dev = "/dev";
  std::string tty_class = "/sys/class/tty";
};

// `device` is drivers.kobuki.device, that is one of
//   a path      returned as it is;
//   a serial    (no slash) of the USB adapter: the port of the adapter with it, wherever it is
//               plugged in;
//   auto        /dev/kobuki when it is there (udev rule), else the only adapter whose serial begins
//               with "kobuki".
// Errors: kNotFound (none is there), kBadConfig (`auto` finds several). Both say which serial
// numbers there are.
Result<std::string> FindPort(const std::string& device, const SystemRoots& roots = {});

}  // namespace gw::kobuki

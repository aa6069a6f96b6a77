// Resets a device on the USB, as if it were unplugged and plugged in again (libusb).
#pragma once

#include "common/core/result.h"

namespace gw::camera {

// Errors: kNotFound (no such device), kIo (no permission, or the reset failed).
Result<Done> ResetUsbDevice(int bus, int address);

}  // namespace gw::camera

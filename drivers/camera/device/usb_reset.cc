#include "drivers/camera/device/usb_reset.h"

#include <libusb-1.0/libusb.h>

#include <memory>
#include <string>

namespace gw::camera {
namespace {

struct FreeList {
  void operator()(libusb_device** list) const { libusb_free_device_list(list, 1); }
};
struct Exit {
  void operator()(libusb_context* context) const { libusb_exit(context); }
};

Result<Done> Reset(libusb_device* device) {
  libusb_device_handle* handle = nullptr;
  int failed = libusb_open(device, &handle);
  if (failed == 0) {
    failed = libusb_reset_device(handle);
    libusb_close(handle);
  }
  // "Not found" is success: the device has come back under another address.
  if (failed == 0 || failed == LIBUSB_ERROR_NOT_FOUND) return Done{};
  return Error{ErrorCode::kIo,
               std::string("cannot reset the camera on the USB: ") +
                   libusb_strerror(static_cast<libusb_error>(failed)) +
                   (failed == LIBUSB_ERROR_ACCESS ? ": install the udev rules" : "")};
}

}  // namespace

Result<Done> ResetUsbDevice(int bus, int address) {
  libusb_context* raw = nullptr;
  if (const int failed = libusb_init(&raw); failed != 0) {
    return Error{ErrorCode::kIo,
                 std::string("no USB: ") + libusb_strerror(static_cast<libusb_error>(failed))};
  }
  const std::unique_ptr<libusb_context, Exit> context(raw);
  libusb_device** devices = nullptr;
  const ssize_t count = libusb_get_device_list(context.get(), &devices);
  const std::unique_ptr<libusb_device*, FreeList> list(devices);
  for (ssize_t i = 0; i < count; ++i) {
    if (libusb_get_bus_number(devices[i]) == bus &&
        libusb_get_device_address(devices[i]) == address) {
      return Reset(devices[i]);
    }
  }
  return Error{ErrorCode::kNotFound, "no USB device " + std::to_string(bus) + ":" +
                                         std::to_string(address) + " to reset"};
}

}  // namespace gw::camera

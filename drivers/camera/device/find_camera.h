// Which video nodes and motion sensors belong to the camera? Read from sysfs alone; nothing is
// opened.
#pragma once

#include <string>
#include <vector>

#include "common/config/camera_config.h"
#include "common/core/result.h"

namespace gw::camera {

// Where the system keeps devices; tests make their own.
struct SystemRoots {
  std::string dev = "/dev";
  std::string sys = "/sys";
};

struct FoundNode {
  std::string path;          // "/dev/video2"
  int number = 0;            // 2
  int interface_number = 0;  // of the USB device: 0 stereo, 3 colour for a D435i
};

struct FoundCamera {
  std::string serial;  // of the USB device; empty: not on USB
  std::string product;
  int speed_mbps = 0;            // 480: USB 2; 5000 and more: USB 3; 0: not on USB
  int bus = 0, address = 0;      // on USB; 0: not on USB
  std::vector<FoundNode> nodes;  // by number
  std::string gyro, accel;       // folders of the motion sensors in sysfs; empty: none

  bool usb2() const { return speed_mbps > 0 && speed_mbps <= 480; }
};

// All cameras of the source's kind (realsense: D435i; uvc: every camera), by serial number.
std::vector<FoundCamera> ListCameras(CameraSource source, const SystemRoots& roots);

// The one that `device` names: drivers.camera.device. Errors, which say what is plugged in:
// kNotFound; kBadConfig: `auto` finds several.
Result<FoundCamera> FindCamera(CameraSource source, const std::string& device,
                               const SystemRoots& roots = {});

}  // namespace gw::camera

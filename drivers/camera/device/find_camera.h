// Finds out which video nodes and motion sensors belong to the camera, from sysfs alone; nothing is
// opened.
#pragma once

#include <string>
#include <vector>

#include "common/config/camera_config.h"
#include "common/core/result.h"

namespace gw::camera {

// The folders in which the system keeps devices; tests make their own.
struct SystemRoots {
  std::string dev = "/dev";
  std::string sys = "/sys";
};

struct FoundNode {
  std::string path;          // "/dev/video2"
  int number = 0;            // 2
  int interface_number = 0;  // interface of the USB device; of a D435i 0 is stereo, 3 colour
};

struct FoundCamera {
  std::string serial;  // serial number of the USB device; empty when not on USB
  std::string product;
  int speed_mbps = 0;            // 480 is USB 2, 5000 and more is USB 3, 0 is not on USB
  int bus = 0, address = 0;      // place on the USB; 0 when not on USB
  std::vector<FoundNode> nodes;  // in order of their number
  // Folders of the motion sensors in sysfs; empty when there are none.
  std::string gyro, accel;

  bool usb2() const { return speed_mbps > 0 && speed_mbps <= 480; }
};

// All cameras of the source's kind (realsense: D435i; uvc: every camera), by serial number.
std::vector<FoundCamera> ListCameras(CameraSource source, const SystemRoots& roots);

// The camera that `device` (drivers.camera.device) names. Errors say what is plugged in: kNotFound,
// or kBadConfig when `auto` finds several.
Result<FoundCamera> FindCamera(CameraSource source, const std::string& device,
                               const SystemRoots& roots = {});

}  // namespace gw::camera

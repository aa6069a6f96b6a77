// A /dev and a /sys of our own with the files of a D435i, as the kernel lays them out.
#pragma once

#include <filesystem>
#include <string>

#include "drivers/camera/device/find_camera.h"

namespace gw::camera {

class FakeSystem {
 public:
  // folder: made here and removed in the end.
  explicit FakeSystem(std::filesystem::path folder);
  ~FakeSystem();
  FakeSystem(const FakeSystem&) = delete;
  FakeSystem& operator=(const FakeSystem&) = delete;

  const SystemRoots& roots() const { return roots_; }

  struct UsbCamera {
    std::string port;  // "2-1", names the folder
    std::string vendor = "8086", product = "0b3a", serial = "a1b2c3d4e5f6";
    int speed_mbps = 5000;
    int first_node = 0;  // six nodes from here on
    int first_iio = 0;   // two devices from here on
  };
  void Plug(const UsbCamera& camera);
  void Unplug(const UsbCamera& camera);
  // The camera stays on the USB; its video devices vanish.
  void UnloadVideoDriver(const UsbCamera& camera);
  // A camera that is not on USB, as vivid.
  void AddVirtual(int node, const std::string& name);

  // Of the motion sensors: "gyro_3d" or "accel_3d"'s folder in sysfs.
  std::filesystem::path IioFolder(int number) const;

 private:
  void AddNode(const std::filesystem::path& interface_folder, int number);
  void AddMotionSensor(const UsbCamera& camera, int number, const std::string& name,
                       const std::string& prefix);

  std::filesystem::path folder_;
  SystemRoots roots_;
};

}  // namespace gw::camera

// Makes a /dev and a /sys with the files of a D435i, as the kernel lays them out.
#pragma once

#include <filesystem>
#include <string>

#include "drivers/camera/device/find_camera.h"

namespace gw::camera {

class FakeSystem {
 public:
  // `folder` is made here and removed in the end.
  explicit FakeSystem(std::filesystem::path folder);
  ~FakeSystem();
  FakeSystem(const FakeSystem&) = delete;
  FakeSystem& operator=(const FakeSystem&) = delete;

  const SystemRoots& roots() const { return roots_; }

  struct UsbCamera {
    std::string port;  // the port "2-1" names the folder
    std::string vendor = "8086", product = "0b3a", serial = "a1b2c3d4e5f6";
    int speed_mbps = 5000;
    int first_node = 0;  // number of the first of six nodes
    int first_iio = 0;   // number of the first of two devices
  };
  void Plug(const UsbCamera& camera);
  void Unplug(const UsbCamera& camera);
  // Takes the video driver away: the camera stays on the USB, its video devices vanish.
  void UnloadVideoDriver(const UsbCamera& camera);
  // Adds a camera that is not on USB, like vivid.
  void AddVirtual(int node, const std::string& name);

  // The folder in sysfs of the motion sensor "gyro_3d" or "accel_3d".
  std::filesystem::path IioFolder(int number) const;

 private:
  void AddNode(const std::filesystem::path& interface_folder, int number);
  void AddMotionSensor(const UsbCamera& camera, int number, const std::string& name,
                       const std::string& prefix);

  std::filesystem::path folder_;
  SystemRoots roots_;
};

}  // namespace gw::camera

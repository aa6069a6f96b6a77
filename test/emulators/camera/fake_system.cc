#include "test/emulators/camera/fake_system.h"

#include <sys/stat.h>

#include <fstream>

namespace gw::camera {
namespace {

namespace fs = std::filesystem;

void WriteFile(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file) << text << "\n";
}

}  // namespace

FakeSystem::FakeSystem(fs::path folder) : folder_(std::move(folder)) {
  fs::remove_all(folder_);
  roots_ = {folder_ / "dev", folder_ / "sys"};
  fs::create_directories(folder_ / "dev");
  fs::create_directories(folder_ / "sys/class/video4linux");
  fs::create_directories(folder_ / "sys/bus/iio/devices");
  fs::create_directories(folder_ / "sys/bus/usb/devices");
}

FakeSystem::~FakeSystem() {
  fs::remove_all(folder_);
}

fs::path FakeSystem::IioFolder(int number) const {
  return folder_ / "sys/bus/iio/devices" / ("iio:device" + std::to_string(number));
}

void FakeSystem::AddNode(const fs::path& interface_folder, int number) {
  const std::string name = "video" + std::to_string(number);
  const fs::path real = interface_folder / "video4linux" / name;
  fs::create_directories(real);
  fs::create_directory_symlink(interface_folder, real / "device");
  fs::create_directory_symlink(real, folder_ / "sys/class/video4linux" / name);
}

void FakeSystem::AddMotionSensor(const UsbCamera& camera, int number, const std::string& name,
                                 const std::string& prefix) {
  const std::string device = "iio:device" + std::to_string(number);
  const fs::path real = folder_ / "sys/devices/usb" / camera.port / (camera.port + ":1.5") /
                        "0003:8086:0B3A.0001" / device;
  WriteFile(real / "name", name);
  for (int i = 0; i < 3; ++i) {
    const std::string channel = prefix + "_" + "xyz"[i];
    WriteFile(real / "scan_elements" / (channel + "_en"), "0");
    WriteFile(real / "scan_elements" / (channel + "_index"), std::to_string(i));
    WriteFile(real / "scan_elements" / (channel + "_type"), "le:s32/32>>0");
  }
  WriteFile(real / "scan_elements/in_timestamp_en", "0");
  WriteFile(real / "scan_elements/in_timestamp_index", "3");
  WriteFile(real / "scan_elements/in_timestamp_type", "le:s64/64>>0");
  WriteFile(real / (prefix + "_sampling_frequency"), "0");
  WriteFile(real / "trigger/current_trigger", "");
  WriteFile(real / "current_timestamp_clock", "realtime");
  WriteFile(real / "buffer/length", "2");
  WriteFile(real / "buffer/enable", "1");  // as the kernel leaves accel_3d
  fs::create_directory_symlink(real, IioFolder(number));
  ::mkfifo((folder_ / "dev" / device).c_str(), 0600);
}

void FakeSystem::Plug(const UsbCamera& camera) {
  const fs::path usb = folder_ / "sys/devices/usb" / camera.port;
  WriteFile(usb / "idVendor", camera.vendor);
  WriteFile(usb / "idProduct", camera.product);
  WriteFile(usb / "serial", camera.serial);
  WriteFile(usb / "product", "Intel(R) RealSense(TM) Depth Camera 435i");
  WriteFile(usb / "speed", std::to_string(camera.speed_mbps));
  WriteFile(usb / "busnum", "2");
  WriteFile(usb / "devnum", "7");
  fs::create_directory_symlink(usb, folder_ / "sys/bus/usb/devices" / camera.port);
  for (int i = 0; i < 6; ++i) {
    const int number = i < 4 ? 0 : 3;
    const fs::path interface_folder = usb / (camera.port + ":1." + std::to_string(number));
    WriteFile(interface_folder / "bInterfaceNumber", "0" + std::to_string(number));
    AddNode(interface_folder, camera.first_node + i);
  }
  AddMotionSensor(camera, camera.first_iio, "accel_3d", "in_accel");
  AddMotionSensor(camera, camera.first_iio + 1, "gyro_3d", "in_anglvel");
}

void FakeSystem::UnloadVideoDriver(const UsbCamera& camera) {
  for (int i = 0; i < 6; ++i) {
    fs::remove(folder_ / "sys/class/video4linux" /
               ("video" + std::to_string(camera.first_node + i)));
  }
}

void FakeSystem::Unplug(const UsbCamera& camera) {
  UnloadVideoDriver(camera);
  fs::remove(folder_ / "sys/bus/usb/devices" / camera.port);
  for (int i = 0; i < 2; ++i) {
    fs::remove(IioFolder(camera.first_iio + i));
    fs::remove(folder_ / "dev" / ("iio:device" + std::to_string(camera.first_iio + i)));
  }
  fs::remove_all(folder_ / "sys/devices/usb" / camera.port);
}

void FakeSystem::AddVirtual(int node, const std::string& name) {
  const fs::path device = folder_ / "sys/devices/virtual" / ("vivid." + std::to_string(node));
  AddNode(device, node);
  WriteFile(device / "video4linux" / ("video" + std::to_string(node)) / "name", name);
}

}  // namespace gw::camera

#include "drivers/camera/device/find_camera.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include "drivers/camera/device/sysfs.h"

namespace gw::camera {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVendorIntel = "8086";
constexpr const char* kProductD435i = "0b3a";

// The folder without symbolic links; empty when there is none.
fs::path RealFolder(const fs::path& path) {
  std::error_code error;
  fs::path real = fs::canonical(path, error);
  return error ? fs::path() : real;
}

// The folder of the USB device that this folder belongs to; empty when it is not on USB.
fs::path UsbDeviceOf(fs::path folder) {
  for (int level = 0; level < 12 && folder.has_relative_path(); ++level) {
    std::error_code error;
    if (fs::exists(folder / "idVendor", error)) return folder;
    folder = folder.parent_path();
  }
  return {};
}

int NumberBehind(const std::string& name, const std::string& prefix) {
  int number = -1;
  if (name.rfind(prefix, 0) != 0) return -1;
  const char* end = name.data() + name.size();
  const auto parsed = std::from_chars(name.data() + prefix.size(), end, number);
  return parsed.ec == std::errc() && parsed.ptr == end ? number : -1;
}

FoundCamera Describe(const fs::path& usb) {
  FoundCamera camera;
  camera.serial = ReadSysfs(usb / "serial");
  camera.product = ReadSysfs(usb / "product");
  camera.speed_mbps = ReadSysfsNumber(usb / "speed");
  camera.bus = ReadSysfsNumber(usb / "busnum");
  camera.address = ReadSysfsNumber(usb / "devnum");
  return camera;
}

bool IsOfSource(CameraSource source, const fs::path& usb) {
  if (source != CameraSource::kRealsense) return true;
  return !usb.empty() && ReadSysfs(usb / "idVendor") == kVendorIntel &&
         ReadSysfs(usb / "idProduct") == kProductD435i;
}

void AddMotionSensors(const SystemRoots& roots, std::map<fs::path, FoundCamera>* cameras) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(fs::path(roots.sys) / "bus/iio/devices", error)) {
    const std::string name = ReadSysfs(entry.path() / "name");
    const auto camera = cameras->find(UsbDeviceOf(RealFolder(entry.path())));
    if (camera == cameras->end() || camera->first.empty()) continue;
    if (name == "gyro_3d") camera->second.gyro = entry.path();
    if (name == "accel_3d") camera->second.accel = entry.path();
  }
}

std::string Text(const FoundCamera& camera) {
  return (camera.serial.empty() ? camera.nodes.front().path : camera.serial) +
         (camera.product.empty() ? "" : " (" + camera.product + ")");
}

std::string List(const std::vector<FoundCamera>& cameras) {
  std::string out;
  for (const FoundCamera& camera : cameras) out += (out.empty() ? "" : ", ") + Text(camera);
  return out;
}

bool Fits(const FoundCamera& camera, const std::string& device) {
  if (device == "auto" || camera.serial == device) return true;
  return std::any_of(camera.nodes.begin(), camera.nodes.end(),
                     [&](const FoundNode& node) { return node.path == device; });
}

// The serial number of a D435i that is on the USB. The kernel may still have made no video device
// of it.
std::optional<std::string> OnUsb(const SystemRoots& roots) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(fs::path(roots.sys) / "bus/usb/devices", error)) {
    if (IsOfSource(CameraSource::kRealsense, entry.path())) {
      return ReadSysfs(entry.path() / "serial");
    }
  }
  return std::nullopt;
}

Error NotFound(CameraSource source, const std::string& device, const std::vector<FoundCamera>& all,
               const SystemRoots& roots) {
  const bool realsense = source == CameraSource::kRealsense;
  if (const auto serial = OnUsb(roots); serial && realsense && all.empty()) {
    return {ErrorCode::kNotFound, "RealSense D435i " + *serial +
                                      " is on the USB, but the kernel made no video device of it: "
                                      "load its driver (modprobe uvcvideo)"};
  }
  const bool any = device == "auto";
  return {ErrorCode::kNotFound,
          std::string("no ") + (realsense ? "RealSense D435i" : "camera") +
              (any ? "" : " " + device) + " found (" +
              (all.empty() ? "none is plugged in" : "plugged in: " + List(all)) +
              (any ? "): plug it in" : "): plug it in, or correct drivers.camera.device")};
}

}  // namespace

std::vector<FoundCamera> ListCameras(CameraSource source, const SystemRoots& roots) {
  // Cameras that are not on USB are told apart by their node.
  std::map<fs::path, FoundCamera> by_usb;
  std::vector<FoundCamera> out;
  std::error_code error;
  for (const auto& entry :
       fs::directory_iterator(fs::path(roots.sys) / "class/video4linux", error)) {
    const std::string name = entry.path().filename();
    const int number = NumberBehind(name, "video");
    if (number < 0) continue;
    const fs::path interface_folder = RealFolder(entry.path() / "device");
    const fs::path usb = UsbDeviceOf(interface_folder);
    if (!IsOfSource(source, usb)) continue;
    FoundNode node{fs::path(roots.dev) / name, number,
                   ReadSysfsNumber(interface_folder / "bInterfaceNumber", 16)};
    if (usb.empty()) {
      FoundCamera camera;
      camera.product = ReadSysfs(entry.path() / "name");
      camera.nodes.push_back(node);
      out.push_back(camera);
      continue;
    }
    auto place = by_usb.find(usb);
    if (place == by_usb.end()) place = by_usb.emplace(usb, Describe(usb)).first;
    place->second.nodes.push_back(node);
  }
  AddMotionSensors(roots, &by_usb);
  for (auto& [usb, camera] : by_usb) out.push_back(std::move(camera));
  for (FoundCamera& camera : out) {
    std::sort(camera.nodes.begin(), camera.nodes.end(),
              [](const auto& a, const auto& b) { return a.number < b.number; });
  }
  std::sort(out.begin(), out.end(), [](const FoundCamera& a, const FoundCamera& b) {
    return std::pair(a.serial, a.nodes.front().number) <
           std::pair(b.serial, b.nodes.front().number);
  });
  return out;
}

Result<FoundCamera> FindCamera(CameraSource source, const std::string& device,
                               const SystemRoots& roots) {
  const std::vector<FoundCamera> all = ListCameras(source, roots);
  std::vector<FoundCamera> fitting;
  std::copy_if(all.begin(), all.end(), std::back_inserter(fitting),
               [&](const FoundCamera& camera) { return Fits(camera, device); });
  if (fitting.size() == 1) return fitting.front();
  if (fitting.empty()) return NotFound(source, device, all, roots);
  return Error{ErrorCode::kBadConfig, "several cameras found (" + List(fitting) +
                                          "): set drivers.camera.device to one of them"};
}

}  // namespace gw::camera

#include "drivers/kobuki/device/find_port.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <utility>
#include <vector>

namespace gw::kobuki {
namespace {

namespace fs = std::filesystem;

struct Adapter {
  std::string serial;
  std::string port;  // "ttyUSB0"
  bool operator<(const Adapter& other) const { return serial < other.serial; }
};

// The serial number, which stands in the USB device's folder, some levels above that of the port.
std::string SerialOf(const fs::path& tty) {
  std::error_code error;
  fs::path folder = fs::canonical(tty / "device", error);
  for (int level = 0; level < 5 && !error && folder.has_relative_path(); ++level) {
    std::ifstream vendor(folder / "idVendor");
    std::string id;
    if (vendor >> id) {
      std::ifstream file(folder / "serial");
      std::string serial;
      file >> serial;
      return serial;
    }
    folder = folder.parent_path();
  }
  return "";
}

std::vector<Adapter> FindAdapters(const std::string& tty_class) {
  std::vector<Adapter> out;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(tty_class, error)) {
    const std::string serial = SerialOf(entry.path());
    if (!serial.empty()) out.push_back({serial, entry.path().filename()});
  }
  std::sort(out.begin(), out.end());
  return out;
}

std::string List(const std::vector<Adapter>& adapters) {
  std::string out;
  for (const Adapter& a : adapters) out += (out.empty() ? "" : ", ") + a.serial;
  return out.empty() ? "no USB serial adapter is plugged in" : "plugged in: " + out;
}

}  // namespace

Result<std::string> FindPort(const std::string& device, const SystemRoots& roots) {
  if (device.find('/') != std::string::npos) return device;
  const bool any = device == "auto";
  std::error_code error;
  const fs::path symlink = fs::path(roots.dev) / "kobuki";
  if (any && fs::exists(symlink, error)) return symlink.string();
  const std::vector<Adapter> adapters = FindAdapters(roots.tty_class);
  std::vector<Adapter> fitting;
  std::copy_if(adapters.begin(), adapters.end(), std::back_inserter(fitting), [&](const auto& a) {
    return any ? a.serial.rfind("kobuki", 0) == 0 : a.serial == device;
  });
  if (fitting.size() == 1) return (fs::path(roots.dev) / fitting[0].port).string();
  if (fitting.empty()) {
    return Error{ErrorCode::kNotFound,
                 (any ? std::string("no Kobuki found")
                      : "no adapter with serial number " + device + " found") +
                     " (" + List(adapters) + "): plug in the base's USB cable, or set " +
                     "drivers.kobuki.device"};
  }
  return Error{ErrorCode::kBadConfig, "several bases found (" + List(fitting) +
                                          "): set drivers.kobuki.device to one of them"};
}

}  // namespace gw::kobuki

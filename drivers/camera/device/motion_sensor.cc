#include "drivers/camera/device/motion_sensor.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "drivers/camera/device/sysfs.h"

namespace gw::camera {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBufferRows = "128";

Result<IioLayout> ReadLayout(const fs::path& folder, const std::array<std::string, 4>& channels) {
  std::vector<IioChannel> out;
  for (const std::string& name : channels) {
    const fs::path element = folder / "scan_elements";
    auto channel = ParseIioChannel(name, ReadSysfs(element / (name + "_index")),
                                   ReadSysfs(element / (name + "_type")));
    if (!channel) return channel.error();
    out.push_back(std::move(*channel));
  }
  return IioLayout::Create(std::move(out));
}

// Sets the sensor up. The order matters: a buffer that was left on refuses everything else, and the
// buffer must be full-size and triggered before it is switched on.
Result<Done> SetUp(const fs::path& folder, const std::array<std::string, 4>& channels,
                   const std::string& prefix, int frequency_code) {
  std::vector<std::pair<fs::path, std::string>> writes{{folder / "buffer/enable", "0"}};
  for (const std::string& name : channels) {
    writes.emplace_back(folder / "scan_elements" / (name + "_en"), "1");
  }
  const std::string name = folder.filename();
  const std::string number = name.substr(name.find_first_of("0123456789"));
  writes.emplace_back(folder / (prefix + "_sampling_frequency"), std::to_string(frequency_code));
  writes.emplace_back(folder / "trigger/current_trigger",
                      ReadSysfs(folder / "name") + "-dev" + number);
  writes.emplace_back(folder / "current_timestamp_clock", "monotonic");
  writes.emplace_back(folder / "buffer/length", kBufferRows);
  writes.emplace_back(folder / "buffer/enable", "1");
  for (const auto& [file, value] : writes) {
    if (const auto written = WriteSysfs(file, value); !written) return written.error();
  }
  return Done{};
}

}  // namespace

Result<MotionSensor> MotionSensor::Open(const std::string& folder, const std::string& prefix,
                                        int frequency_code, const SystemRoots& roots) {
  const std::array<std::string, 4> channels{prefix + "_x", prefix + "_y", prefix + "_z",
                                            "in_timestamp"};
  const fs::path path(folder);
  auto layout = ReadLayout(path, channels);
  if (!layout) return Error{layout.error().code, folder + ": " + layout.error().message};
  if (const auto set = SetUp(path, channels, prefix, frequency_code); !set) return set.error();
  const fs::path node = fs::path(roots.dev) / path.filename();
  process::FileHandle handle(::open(node.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (!handle.valid()) {
    return Error{ErrorCode::kIo, node.string() + ": cannot open: " + std::strerror(errno) +
                                     ": install the udev rules, or stop who uses it"};
  }
  std::array<int, 4> places{};
  for (size_t i = 0; i < places.size(); ++i) places[i] = layout->Find(channels[i]);
  return MotionSensor(folder, std::move(*layout), places, std::move(handle));
}

MotionSensor::~MotionSensor() {
  if (node_.valid()) (void)WriteSysfs(fs::path(folder_) / "buffer/enable", "0");
}

Result<std::vector<MotionRow>> MotionSensor::Read() {
  std::vector<MotionRow> out;
  std::array<uint8_t, 4096> buffer;
  const ssize_t n = ::read(node_.get(), buffer.data(), buffer.size());
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return out;
  if (n <= 0) {
    return Error{ErrorCode::kIo, folder_ + ": the motion sensor is gone: " +
                                     (n == 0 ? "end" : std::strerror(errno))};
  }
  partial_.insert(partial_.end(), buffer.begin(), buffer.begin() + n);
  const size_t row_bytes = layout_.row_bytes();
  size_t at = 0;
  for (; at + row_bytes <= partial_.size(); at += row_bytes) {
    const auto values = layout_.Decode(std::span(partial_).subspan(at, row_bytes));
    const auto value = [&](size_t i) { return values[static_cast<size_t>(places_[i])]; };
    out.push_back({{value(0), value(1), value(2)}, value(3)});
  }
  partial_.erase(partial_.begin(), partial_.begin() + static_cast<ptrdiff_t>(at));
  return out;
}

}  // namespace gw::camera

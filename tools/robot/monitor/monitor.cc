#include "tools/robot/monitor/monitor.h"

#include <algorithm>
#include <cinttypes>
#include <filesystem>
#include <set>

#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/data/files/format.h"
#include "tools/data/files/text_file.h"

namespace gw::tools {

Result<Done> Monitor::Attach(process::Bus& bus, Monitor& monitor) {
  auto ok = bus.Subscribe(wire::kCamera, [&monitor](auto bytes, Utime received) {
    if (const auto header = wire::ReadHeader(bytes)) {
      monitor.image_received_.emplace(header->utime.us, received);
    }
  });
  if (!ok) return ok;
  ok = bus.Subscribe(wire::kFramePose, [&monitor](auto bytes, Utime received) {
    const auto pose = wire::Decode<FramePose>(bytes);
    if (!pose) return;
    const auto image = monitor.image_received_.find(pose->utime.us);
    const int64_t latency =
        image == monitor.image_received_.end() ? 0 : (received - image->second).us;
    monitor.frames_.push_back({*pose, latency});
  });
  if (!ok) return ok;
  ok = bus.Subscribe(wire::kPose, [&monitor](auto bytes, Utime received) {
    if (const auto header = wire::ReadHeader(bytes)) {
      monitor.pose_arrivals_.push_back({received, header->utime});
    }
  });
  if (!ok) return ok;
  ok = bus.Subscribe(wire::kHealth, [&monitor](auto bytes, Utime) {
    if (auto health = wire::Decode<Health>(bytes)) monitor.health_.push_back(std::move(*health));
  });
  if (!ok) return ok;
  ok = bus.Subscribe(wire::kGroundTruth, [&monitor](auto bytes, Utime) {
    if (auto truth = wire::Decode<GroundTruth>(bytes)) monitor.truth_.push_back(*truth);
  });
  if (!ok) return ok;
  return bus.Subscribe(wire::kNote, [&monitor](auto bytes, Utime) {
    if (auto note = wire::Decode<wire::Note>(bytes)) monitor.notes_.push_back(std::move(*note));
  });
}

int64_t Monitor::images_without_pose() const {
  std::set<int64_t> with_pose;
  for (const Frame& f : frames_) with_pose.insert(f.pose.utime.us);
  return static_cast<int64_t>(
      std::count_if(image_received_.begin(), image_received_.end(),
                    [&](const auto& image) { return !with_pose.contains(image.first); }));
}

int64_t Monitor::LatencyQuantile(double q) const {
  std::vector<int64_t> latencies;
  for (const Frame& f : frames_) latencies.push_back(f.latency_us);
  if (latencies.empty()) return 0;
  std::sort(latencies.begin(), latencies.end());
  return latencies[static_cast<size_t>(q * static_cast<double>(latencies.size() - 1))];
}

std::map<std::string, Health> Monitor::NewestHealth() const {
  std::map<std::string, Health> newest;
  for (const Health& h : health_) newest[h.process] = h;
  return newest;
}

std::string Monitor::StatusLine() const {
  std::string line = Format("images %" PRId64 ", poses %" PRId64 ", without pose %" PRId64
                            ", latency median %.1f ms p99 %.1f ms",
                            images(), poses(), images_without_pose(),
                            static_cast<double>(LatencyQuantile(0.5)) * 1e-3,
                            static_cast<double>(LatencyQuantile(0.99)) * 1e-3);
  const char* names[] = {"?", "starting", "ok", "degraded", "failed"};
  for (const auto& [process, health] : NewestHealth()) {
    line += ", " + process + " " + names[static_cast<int>(health.state)];
  }
  return line;
}

Result<Done> Monitor::Write(const std::string& folder) const {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return Error{ErrorCode::kIo, folder + ": cannot be made: " + error.message()};
  std::string trajectory, truth;
  for (const Frame& f : frames_) trajectory += TumLine(f.pose.utime, f.pose.T_WB);
  for (const GroundTruth& t : truth_) truth += TumLine(t.utime, t.T_GB);

  std::string frames = "utime,status,n_inliers,map_revision,latency_us\n";
  for (const Frame& f : frames_) {
    frames += Format("%" PRId64 ",%d,%d,%" PRId64 ",%" PRId64 "\n", f.pose.utime.us,
                     static_cast<int>(f.pose.status), f.pose.num_inliers, f.pose.map_revision,
                     f.latency_us);
  }
  std::string pose_times = "received,utime\n";
  for (const PoseArrival& p : pose_arrivals_) {
    pose_times += Format("%" PRId64 ",%" PRId64 "\n", p.received.us, p.utime.us);
  }
  std::string health = "utime,process,state,latency_p50_us,latency_p99_us,counters\n";
  for (const Health& h : health_) {
    health += Format("%" PRId64 ",%s,%d,%" PRId64 ",%" PRId64 ",", h.utime.us, h.process.c_str(),
                     static_cast<int>(h.state), h.latency_p50_us, h.latency_p99_us);
    for (const auto& [name, n] : h.counters) health += Format("%s=%" PRId64 ";", name.c_str(), n);
    health += "\n";
  }

  std::vector<std::pair<std::string, const std::string*>> files = {{"trajectory.tum", &trajectory},
                                                                   {"frames.csv", &frames},
                                                                   {"pose_times.csv", &pose_times},
                                                                   {"health.csv", &health}};
  if (!truth_.empty()) files.emplace_back("ground_truth.tum", &truth);
  for (const auto& [name, text] : files) {
    auto written = WriteTextFile((std::filesystem::path(folder) / name).string(), *text);
    if (!written) return written;
  }
  return Done{};
}

}  // namespace gw::tools

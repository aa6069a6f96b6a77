// Prints what is on the bus, one line at a time, for tests that watch processes from outside:
//
//   HEALTH gw-camera state=2 camera.lost=0 ... message="..."
//   CAMERA n=25 lost=0 gaps_ms=39..41 640x480      every 25 images
//   WHEEL n=50 lost=0 ticks=12345,12399 dx_m=0.123 dyaw_rad=0.01      every 50 samples, sums
//   IMU n=200 lost=0                               every 200 samples
//
// Given a speed and a turn rate it commands them ten times a second instead, until it is stopped.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "common/process/bus.h"
#include "common/process/clock.h"
#include "common/process/loop.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"

namespace gw {
namespace {

class Probe {
 public:
  void OnHealth(const Health& health) {
    std::printf("HEALTH %s state=%d", health.process.c_str(), static_cast<int>(health.state));
    for (const auto& [name, value] : health.counters) {
      std::printf(" %s=%lld", name.c_str(), static_cast<long long>(value));
    }
    std::printf(" message=\"%s\"\n", health.message.c_str());
    std::fflush(stdout);
  }
  void OnCamera(const CameraFrame& frame) {
    const int64_t n = Count("CAMERA", frame.seq);
    if (n > 1) {
      const double gap_ms = (frame.utime - camera_utime_).seconds() * 1e3;
      least_gap_ms_ = std::min(least_gap_ms_, gap_ms);
      most_gap_ms_ = std::max(most_gap_ms_, gap_ms);
    }
    camera_utime_ = frame.utime;
    if (n % 25 != 0) return;
    std::printf("CAMERA n=%lld lost=%lld gaps_ms=%.1f..%.1f %dx%d\n", static_cast<long long>(n),
                static_cast<long long>(lost_["CAMERA"]), least_gap_ms_, most_gap_ms_,
                frame.left.width, frame.left.height);
    std::fflush(stdout);
    least_gap_ms_ = 1e9;
    most_gap_ms_ = 0;
  }
  void OnWheel(const WheelSample& sample) {
    dx_m_ += sample.dx_m;
    dyaw_rad_ += sample.dyaw_rad;
    const int64_t n = Count("WHEEL", sample.seq);
    if (n % 50 != 0) return;
    std::printf("WHEEL n=%lld lost=%lld ticks=%d,%d dx_m=%.4f dyaw_rad=%.4f\n",
                static_cast<long long>(n), static_cast<long long>(lost_["WHEEL"]),
                sample.left_ticks, sample.right_ticks, dx_m_, dyaw_rad_);
    std::fflush(stdout);
  }
  void OnImu(const ImuSample& sample) {
    const int64_t n = Count("IMU", sample.seq);
    if (n % 200 != 0) return;
    std::printf("IMU n=%lld lost=%lld\n", static_cast<long long>(n),
                static_cast<long long>(lost_["IMU"]));
    std::fflush(stdout);
  }

 private:
  // Counts a message and gives how many came on the channel.
  int64_t Count(const std::string& channel, int64_t seq) {
    const int64_t expected = ++next_[channel];
    if (received_[channel] > 0 && seq > expected) lost_[channel] += seq - expected;
    next_[channel] = seq;
    return ++received_[channel];
  }

  std::map<std::string, int64_t> next_, received_, lost_;
  Utime camera_utime_;
  double least_gap_ms_ = 1e9, most_gap_ms_ = 0;
  double dx_m_ = 0, dyaw_rad_ = 0;
};

template <typename T>
Result<Done> Listen(process::Bus* bus, const char* channel, std::function<void(const T&)> handler) {
  return bus->Subscribe(
      channel, [channel, handler = std::move(handler)](std::span<const uint8_t> message, Utime) {
        const auto decoded = wire::Decode<T>(message);
        if (decoded) {
          handler(*decoded);
        } else {
          std::printf("UNDECODABLE %s %s\n", channel, decoded.error().message.c_str());
        }
      });
}

int Drive(process::Loop* loop, process::Bus* bus, double v_m_s, double w_rad_s) {
  const process::Clock clock;
  for (int64_t seq = 1;; ++seq) {
    if (!bus->Publish(wire::kBaseCommand,
                      wire::Encode(BaseCommand{clock.Now(), seq, v_m_s, w_rad_s}))) {
      return 1;
    }
    const auto ready = loop->Wait();
    if (!ready || ready->stop) return ready ? 0 : 1;
  }
}

int Print(process::Loop* loop, process::Bus* raw) {
  Probe probe;
  const bool listening =
      Listen<Health>(raw, wire::kHealth, [&](const Health& h) { probe.OnHealth(h); }).ok() &&
      Listen<wire::DecodedCamera>(raw, wire::kCamera,
                                  [&](const auto& c) { probe.OnCamera(c.frame); })
          .ok() &&
      Listen<WheelSample>(raw, wire::kWheel, [&](const WheelSample& w) { probe.OnWheel(w); })
          .ok() &&
      Listen<ImuSample>(raw, wire::kImu, [&](const ImuSample& i) { probe.OnImu(i); }).ok();
  if (!listening) return 1;
  loop->Watch(raw->fd());
  while (true) {
    const auto ready = loop->Wait();
    if (!ready || ready->stop) return ready ? 0 : 1;
    if (!raw->Pump(0)) return 1;
  }
}

int Main(int argc, char** argv) {
  auto loop = process::Loop::Create(Milliseconds(100));
  auto bus = process::LiveBus::Create(argv[1]);
  if (!loop || !bus) {
    std::fprintf(stderr, "gw-bus-probe: %s\n",
                 (!loop ? loop.error() : bus.error()).message.c_str());
    return 1;
  }
  if (argc == 2) return Print(&*loop, bus->get());
  return Drive(&*loop, bus->get(), std::atof(argv[2]), std::atof(argv[3]));
}

}  // namespace
}  // namespace gw

int main(int argc, char** argv) {
  if (argc != 2 && argc != 4) {
    std::fprintf(stderr, "usage: gw-bus-probe LCM_URL [SPEED_M_S TURN_RATE_RAD_S]\n");
    return 2;
  }
  return gw::Main(argc, argv);
}

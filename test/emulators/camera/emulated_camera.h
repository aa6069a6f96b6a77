// The kernel's side of a D435i in virtual time: video and metadata nodes, buffers, controls and the
// hardware monitor, as system calls. Same configuration and calls: same bytes at the same times.
//
// Faults are switched on by the configuration or while it runs. Time is that of the host's
// monotonic clock, without error: the truth that the driver is measured against.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera/device/system_calls.h"
#include "test/emulators/camera/camera_peer.h"

namespace gw::camera {

// The image of the imagers at one exposure. Depth in mm.
struct EmulatedScene {
  std::vector<uint8_t> left, right;
  std::vector<uint16_t> depth;
};

struct EmulatedCameraConfig {
  uint64_t seed = 1;
  int first_node = 0;        // number of the first of six nodes
  std::string dev = "/dev";  // the folder of the nodes
  int width = 640, height = 480;
  int rate_hz = 30;
  bool has_y8i = true;        // false as on a USB 2 link
  bool d4xx_metadata = true;  // false as with Debian 12's kernel 6.1, which offers UVCH alone
  FirmwareVersion firmware{5, 16, 0, 1};
  StoredCalibration calibration;

  int64_t start_us = 1'000'000;  // start on the host's monotonic clock
  uint32_t first_pts_us = 0;     // the camera's clock at the start
  double clock_ppm = 0;          // how much the camera's clock runs fast
  int64_t delay_us = 5000;       // from the end of the exposure to the first bytes ...
  int64_t jitter_us = 1000;      // ... and the mean of an exponential wait
  uint32_t auto_exposure_us = 6000;
};

class EmulatedCamera : public SystemCalls {
 public:
  using Scene = std::function<EmulatedScene(int64_t frame, bool emitter_on)>;

  EmulatedCamera(const EmulatedCameraConfig& config, Scene scene);

  // Takes images and delivers them, up to this time of the host.
  void AdvanceTo(int64_t monotonic_us);
  // The middle of the exposure of a frame, on the host's clock.
  int64_t MidExposureUs(int64_t frame) const;
  int64_t frames() const { return frame_; }

  int Open(const std::string& path) override;
  void Close(int fd) override;
  int Ioctl(int fd, uint64_t request, void* argument) override;
  uint8_t* Map(int fd, size_t length, int64_t offset) override;
  void Unmap(uint8_t* memory, size_t length) override;
  void Pause() override { ++pauses_; }

  // Faults of the frames to come.
  void LoseFrames(int count) { lose_ = count; }        // makes a gap in the sequence
  void DamageFrames(int count) { damage_ = count; }    // frames are flagged as errors
  void ShortenFrames(int count) { shorten_ = count; }  // a few bytes are missing
  void LoseMetadata(int count) { lose_metadata_ = count; }
  void FailStream();  // DQBUF: EIO until the next start
  // The camera streams, but nothing comes.
  void SetSilent(bool silent) { silent_ = silent; }
  void RefuseStart(int count) { refuse_start_ = count; }        // STREAMON: EPROTO
  void RefuseUnitControls(int count) { refuse_unit_ = count; }  // busy: EIO
  void SetDeviceError(uint8_t code) { device_error_ = code; }
  // Pulls the cable: everything fails with ENODEV until the nodes are closed and opened again.
  void Unplug();
  void Plug() { plugged_ = true; }

  bool emitter_on() const { return emitter_; }
  bool alternating() const { return alternating_; }
  uint32_t laser_power_mw() const { return laser_power_mw_; }
  bool auto_exposure() const { return auto_exposure_; }
  uint32_t exposure_us() const { return auto_exposure_ ? config_.auto_exposure_us : exposure_us_; }
  int32_t gain() const { return gain_; }
  int open_nodes() const { return static_cast<int>(open_.size()); }
  int mapped() const { return mapped_; }
  int pauses() const { return pauses_; }

 private:
  enum class Role { kDepth, kInfrared, kColour };
  struct Buffer {
    std::vector<uint8_t> memory;
    size_t used = 0;
    uint32_t sequence = 0, flags = 0;
    int64_t time_us = 0;
  };
  struct Node {
    Role role = Role::kDepth;
    bool metadata = false;
    uint32_t format = 0;
    bool streaming = false;
    uint32_t sequence = 0;
    std::vector<Buffer> buffers;
    std::deque<uint32_t> queued, filled;
    int event_fd = -1;
  };
  struct Delivery {
    int64_t at_us = 0;
    int64_t frame = 0;
    bool emitter_on = false;
    uint32_t exposure_us = 0;
  };

  std::vector<uint32_t> Formats(const Node& node) const;
  int EnumerateFormat(const Node& node, void* argument) const;
  int EnumerateSize(const Node& node, void* argument) const;
  int EnumerateRate(const Node& node, void* argument) const;
  int SetFormat(Node* node, void* argument) const;
  int RequestBuffers(Node* node, void* argument);
  int TakeBuffer(Node* node, void* argument);
  int StartStream(Node* node);
  int UnitControl(void* argument);
  std::vector<uint8_t> UnitValue(uint8_t selector, uint8_t query) const;
  void SetUnitValue(uint8_t selector, const std::vector<uint8_t>& value);
  void AnswerMonitor(const std::vector<uint8_t>& request);

  // Wakes whoever waits for a node, as an error does in the kernel.
  void WakeAll();
  int64_t EndOfExposureUs(int64_t frame) const;
  void Deliver(const Delivery& delivery);
  void Fill(Node* node, const std::vector<uint8_t>& bytes, int64_t time_us);
  FrameMetadata MetadataOf(const Delivery& delivery) const;

  EmulatedCameraConfig config_;
  Scene scene_;
  std::array<Node, 6> nodes_;
  std::map<int, Node*> open_;
  int64_t frame_ = 0;
  std::deque<Delivery> deliveries_;

  bool emitter_ = true;  // on as after power-on
  bool alternating_ = false;
  uint32_t laser_power_mw_ = 150;
  bool auto_exposure_ = true;
  uint32_t exposure_us_ = 8500;
  int32_t gain_ = 16;
  uint8_t device_error_ = 0;
  std::vector<uint8_t> monitor_answer_;

  int lose_ = 0, damage_ = 0, shorten_ = 0, lose_metadata_ = 0, refuse_start_ = 0, refuse_unit_ = 0;
  bool stream_error_ = false, silent_ = false, plugged_ = true;
  int mapped_ = 0, pauses_ = 0;
};

}  // namespace gw::camera

// One open V4L2 node: its modes and controls, and a stream of buffers that the kernel shares with
// us (mmap). A buffer is copied out and given back at once, so that the kernel never runs short.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "drivers/camera/device/system_calls.h"

namespace gw::camera {

struct VideoMode {
  uint32_t fourcc = 0;
  int width = 0, height = 0;  // px
  double rate_hz = 0;
  std::string text() const;  // "GREY 640x480 at 30 Hz"
};

enum class TakeOutcome {
  kBuffer,
  kNothing,  // no buffer is ready
  kBad,      // a buffer came, but marked as damaged or of the wrong length
  kBroken,   // the stream must be started anew
  kGone,     // the device is not there any more
};

struct Taken {
  TakeOutcome outcome = TakeOutcome::kNothing;
  uint32_t sequence = 0;
  int64_t monotonic_us = 0;  // when its first bytes arrived (uvcvideo), CLOCK_MONOTONIC
  std::vector<uint8_t> bytes;
};

class VideoNode {
 public:
  // Errors: kNotFound (no such node), kIo (no permission, in use, gone), kBadData (not a V4L2
  // node); the text says what to do. `calls` must outlive the node.
  static Result<VideoNode> Open(SystemCalls* calls, const std::string& path);
  VideoNode(VideoNode&& other) noexcept;
  VideoNode& operator=(VideoNode&&) = delete;
  ~VideoNode();

  bool captures_video() const;
  bool captures_metadata() const;
  const std::string& path() const { return path_; }
  int fd() const { return fd_; }

  // The modes that the device offers; sizes and rates that it can do in steps are listed by their
  // largest.
  std::vector<VideoMode> Modes() const;
  bool Offers(uint32_t fourcc) const;
  // Asks for a mode. Error kBadData: the device took another one instead; the text says which.
  Result<Done> SetMode(const VideoMode& mode);
  // Sets the format of a metadata node. Gives the format that the node will deliver, which may be
  // another.
  Result<uint32_t> SetMetadataFormat(uint32_t fourcc);

  // Sets a control. Error kBadData: the device has no such control, or refuses the value.
  Result<Done> SetControl(uint32_t id, int32_t value);
  // Read and write controls of a UVC extension unit. A device that is busy is asked again for 0.2
  // s.
  Result<std::vector<uint8_t>> GetUnitControl(uint8_t unit, uint8_t selector);
  Result<std::vector<uint8_t>> QueryUnitControl(uint8_t unit, uint8_t selector, uint8_t query);
  Result<Done> SetUnitControl(uint8_t unit, uint8_t selector, std::span<const uint8_t> value);

  // Starts the stream. Precondition: a mode or metadata format was set, and the stream is not
  // started.
  Result<Done> Start();
  void Stop();
  bool started() const { return started_; }
  // The next buffer, if one is ready. Precondition: started.
  Taken Take();

  static constexpr uint32_t kBuffers = 6;

 private:
  struct Mapping {
    uint8_t* memory = nullptr;
    size_t length = 0;
  };
  VideoNode(SystemCalls* calls, int fd, std::string path, uint32_t capabilities)
      : calls_(calls), fd_(fd), path_(std::move(path)), capabilities_(capabilities) {}

  uint32_t buffer_type() const;
  Result<Done> MapBuffers();
  void ReleaseBuffers();
  Error Failed(const std::string& what, int error) const;
  Result<Done> UnitQuery(uint8_t unit, uint8_t selector, uint8_t query, std::vector<uint8_t>* data);

  SystemCalls* calls_;
  int fd_;
  std::string path_;
  uint32_t capabilities_;
  size_t image_bytes_ = 0;  // 0 when any length is right (metadata)
  bool started_ = false;
  std::vector<Mapping> mappings_;
};

}  // namespace gw::camera

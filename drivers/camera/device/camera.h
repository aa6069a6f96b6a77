// An opened camera: which of its video nodes gives what, its controls, and the frames of its
// streams.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/camera/calibration.h"
#include "common/config/camera_config.h"
#include "drivers/camera/core/depth_pairer.h"
#include "drivers/camera/core/exposure_control.h"
#include "drivers/camera/core/metadata_joiner.h"
#include "drivers/camera/core/raw_frame.h"
#include "drivers/camera/device/find_camera.h"
#include "drivers/camera/device/video_node.h"
#include "drivers/camera/protocol/calibration_table.h"
#include "drivers/camera/protocol/depth_unit_controls.h"
#include "drivers/camera/protocol/hardware_monitor.h"

namespace gw::camera {

struct CapturedFrame {
  RawFrame image;
  std::optional<RawFrame> depth;
};

enum class StreamState {
  kFine,
  kBroken,  // the stream broke: the camera has to be closed and opened again
  kGone,    // the camera is not there any more
};

struct StreamCounters {
  int64_t images = 0;
  int64_t lost = 0;  // frames missing in the sequence numbers
  int64_t bad = 0;   // frames that are damaged or of the wrong length
  int64_t depth_lost = 0;
  int64_t depth_bad = 0;
  int64_t metadata_bad = 0;
  int64_t without_metadata = 0;
  int64_t unpaired = 0;  // images without depth of the same instant, or the other way round
};

class Camera {
 public:
  // Finds out which node is which, and sets the mode of `calibration` and everything of `config`.
  // Errors: kNotFound (the camera is gone), kIo (no permission, in use), kBadData (the camera took
  // another mode, or does not have the formats that calibration.kind needs). `calls` must outlive
  // the camera.
  static Result<std::unique_ptr<Camera>> Open(SystemCalls* calls, const FoundCamera& found,
                                              const CameraConfig& config,
                                              const CameraCalibration& calibration);

  Result<Done> Start();
  // The descriptors to wait for. Precondition: the camera was started.
  std::vector<int> fds() const;
  // Takes the frames that are ready at one of the descriptors.
  StreamState Read(int fd, std::vector<CapturedFrame>* out);
  const StreamCounters& counters();

  uint32_t image_fourcc() const { return image_mode_.fourcc; }
  bool has_metadata() const { return image_.metadata != nullptr; }
  bool has_d4xx_metadata() const { return d4xx_metadata_; }
  std::string text() const;  // "GREY 640x480 at 30 Hz on /dev/video2, Z16 ..."

  // The firmware and serial numbers, which only a RealSense tells.
  const std::optional<CameraVersion>& version() const { return version_; }
  Result<DepthCalibration> ReadCalibration();
  Result<uint8_t> ReadDeviceError();

  Result<Done> SetExposure(const ExposureSetting& setting);
  // 0 while the camera decides itself.
  uint32_t set_exposure_us() const { return set_exposure_us_; }

 private:
  struct Stream {
    std::unique_ptr<VideoNode> video;
    std::unique_ptr<VideoNode> metadata;  // null where the stream has no metadata node
    std::optional<MetadataJoiner> joiner;
    std::optional<uint32_t> sequence;  // sequence number of the last buffer
  };

  Camera(const CameraConfig& config, const CameraCalibration& calibration);
  Result<Done> OpenNodes(SystemCalls* calls, const FoundCamera& found);
  Result<Done> ChooseStreams(std::vector<std::unique_ptr<VideoNode>> nodes);
  Result<Done> SetModes();
  Result<Done> SetControls();
  Result<Done> SetEmitterMode();
  Result<Done> SetUnit(const UnitControl& control);
  Result<std::vector<uint8_t>> AskMonitor(const MonitorRequest& request);
  // The node that takes the controls of a RealSense: the depth node, whether it streams or not.
  VideoNode& control_node() { return depth_.video ? *depth_.video : *idle_depth_; }

  StreamState ReadVideo(Stream* stream, int64_t* lost, int64_t* bad, std::vector<RawFrame>* out);
  StreamState ReadMetadata(Stream* stream, std::vector<RawFrame>* out);
  void Collect(std::vector<RawFrame> images, std::vector<RawFrame> depths,
               std::vector<CapturedFrame>* out);

  CameraConfig config_;
  CameraCalibration calibration_;
  VideoMode image_mode_;
  Stream image_, depth_;                   // depth_.video is null for stereo
  std::unique_ptr<VideoNode> idle_depth_;  // the depth node of a RealSense that streams both eyes
  bool d4xx_metadata_ = false;
  DepthPairer pairer_;
  std::optional<CameraVersion> version_;
  uint32_t set_exposure_us_ = 0;
  StreamCounters counters_;
};

}  // namespace gw::camera

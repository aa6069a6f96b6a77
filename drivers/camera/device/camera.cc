#include "drivers/camera/device/camera.h"

#include <linux/usb/video.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <utility>

#include "common/core/check.h"
#include "drivers/common/bytes.h"

namespace gw::camera {
namespace {

constexpr int kStereoInterface = 0;
constexpr FirmwareVersion kAlternatingSince{5, 12, 8, 100};
constexpr int32_t kManualExposure = 1;  // value of V4L2_CID_EXPOSURE_AUTO
// Value of the same control: automatic exposure of UVC cameras.
constexpr int32_t kAperturePriority = 3;
constexpr uint32_t kExposureUnitUs = 100;  // unit of V4L2_CID_EXPOSURE_ABSOLUTE

std::string ModeList(const VideoNode& node, uint32_t fourcc) {
  std::string out;
  for (const VideoMode& mode : node.Modes()) {
    if (mode.fourcc == fourcc) out += (out.empty() ? "" : ", ") + mode.text();
  }
  return out.empty() ? "none" : out;
}

uint32_t LittleEndian(const std::vector<uint8_t>& bytes) {
  uint32_t out = 0;
  for (size_t i = 0; i < bytes.size() && i < 4; ++i)
    out |= static_cast<uint32_t>(bytes[i]) << 8 * i;
  return out;
}

}  // namespace

Camera::Camera(const CameraConfig& config, const CameraCalibration& calibration)
    : config_(config),
      calibration_(calibration),
      pairer_(DurationFromSeconds(1 / calibration.rate_hz)) {}

Result<std::unique_ptr<Camera>> Camera::Open(SystemCalls* calls, const FoundCamera& found,
                                             const CameraConfig& config,
                                             const CameraCalibration& calibration) {
  std::unique_ptr<Camera> camera(new Camera(config, calibration));
  if (const auto done = camera->OpenNodes(calls, found); !done) return done.error();
  if (const auto done = camera->SetModes(); !done) return done.error();
  if (const auto done = camera->SetControls(); !done) return done.error();
  return camera;
}

Result<Done> Camera::OpenNodes(SystemCalls* calls, const FoundCamera& found) {
  const bool realsense = config_.source == CameraSource::kRealsense;
  std::vector<std::unique_ptr<VideoNode>> nodes;
  for (const FoundNode& node : found.nodes) {
    if (realsense && node.interface_number != kStereoInterface) continue;
    const bool named = config_.device.find('/') != std::string::npos;
    if (!realsense && named && node.path != config_.device) continue;
    auto opened = VideoNode::Open(calls, node.path);
    if (!opened) return opened.error();
    nodes.push_back(std::make_unique<VideoNode>(std::move(*opened)));
  }
  return ChooseStreams(std::move(nodes));
}

// The nodes come in order of their number: each capture node, and behind it its metadata node.
Result<Done> Camera::ChooseStreams(std::vector<std::unique_ptr<VideoNode>> nodes) {
  const bool realsense = config_.source == CameraSource::kRealsense;
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (!nodes[i] || !nodes[i]->captures_video()) continue;
    Stream stream;
    if (realsense && i + 1 < nodes.size() && nodes[i + 1]->captures_metadata()) {
      stream.metadata = std::move(nodes[i + 1]);
    }
    const bool depth = realsense && nodes[i]->Offers(kZ16);
    const bool grey = nodes[i]->Offers(kGrey) || (!realsense && nodes[i]->Offers(kYuyv));
    stream.video = std::move(nodes[i]);
    if (depth && !depth_.video)
      depth_ = std::move(stream);
    else if (grey && !image_.video)
      image_ = std::move(stream);
  }
  if (!image_.video || (realsense && !depth_.video)) {
    return Error{ErrorCode::kBadData,
                 realsense ? "the camera has no infra-red and depth streams: update its firmware, "
                             "or check the cable"
                           : "the camera offers neither GREY nor YUYV"};
  }
  return Done{};
}

Result<Done> Camera::SetModes() {
  const bool realsense = config_.source == CameraSource::kRealsense;
  const int eyes_in_a_row = config_.source == CameraSource::kUvcSideBySide ? 2 : 1;
  image_mode_ = {kGrey, eyes_in_a_row * calibration_.width, calibration_.height,
                 calibration_.rate_hz};
  if (!realsense && !image_.video->Offers(kGrey)) image_mode_.fourcc = kYuyv;
  if (realsense && calibration_.kind == CameraKind::kStereo) {
    image_mode_.fourcc = kY8i;
    if (!image_.video->Offers(kY8i)) {
      return Error{ErrorCode::kBadData,
                   image_.video->path() +
                       ": the camera offers one eye only (on a USB 2 link it always does): use a "
                       "USB 3 port and cable, or calibration.camera.kind: rgbd"};
    }
    idle_depth_ = std::move(depth_.video);
    depth_ = {};
  }
  const auto set = [](VideoNode* node, const VideoMode& mode) -> Result<Done> {
    auto done = node->SetMode(mode);
    if (done || done.error().code != ErrorCode::kBadData) return done;
    return Error{ErrorCode::kBadData,
                 done.error().message + "; it offers " + ModeList(*node, mode.fourcc)};
  };
  if (const auto done = set(image_.video.get(), image_mode_); !done) return done.error();
  if (depth_.video) {
    VideoMode mode = image_mode_;
    mode.fourcc = kZ16;
    if (const auto done = set(depth_.video.get(), mode); !done) return done.error();
  }
  for (Stream* stream : {&image_, &depth_}) {
    if (stream->metadata) {
      const auto format = stream->metadata->SetMetadataFormat(kMetaD4xx);
      if (!format || (*format != kMetaD4xx && *format != kMetaUvc))
        stream->metadata.reset();
      else
        d4xx_metadata_ = *format == kMetaD4xx;
    }
    stream->joiner.emplace(stream->metadata != nullptr);
  }
  return Done{};
}

Result<Done> Camera::SetUnit(const UnitControl& control) {
  return control_node().SetUnitControl(kDepthUnit, static_cast<uint8_t>(control.selector),
                                       control.value);
}

Result<std::vector<uint8_t>> Camera::AskMonitor(const MonitorRequest& request) {
  const auto selector = static_cast<uint8_t>(Selector::kMonitor);
  const auto asked = control_node().SetUnitControl(kDepthUnit, selector, EncodeRequest(request));
  if (!asked) return asked.error();
  const auto answer = control_node().GetUnitControl(kDepthUnit, selector);
  if (!answer) return answer.error();
  return DecodeAnswer(*answer, request.opcode);
}

Result<Done> Camera::SetEmitterMode() {
  const bool on = config_.emitter != EmitterMode::kOff;
  if (const auto done = SetUnit(SetEmitter(on)); !done) return done.error();
  if (on) {
    const auto selector = static_cast<uint8_t>(Selector::kLaserPower);
    uint32_t limits[3];
    const uint8_t queries[3] = {UVC_GET_MIN, UVC_GET_MAX, UVC_GET_RES};
    for (int i = 0; i < 3; ++i) {
      const auto limit = control_node().QueryUnitControl(kDepthUnit, selector, queries[i]);
      if (!limit) return limit.error();
      limits[i] = LittleEndian(*limit);
    }
    const uint32_t power = ClampToSteps(static_cast<uint32_t>(config_.laser_power_mw), limits[0],
                                        std::max(limits[0], limits[1]), limits[2]);
    const auto done = SetUnit(SetLaserPowerMw(static_cast<uint16_t>(power)));
    if (!done) return done.error();
  }
  const bool alternate = config_.emitter == EmitterMode::kAlternating;
  if (version_->firmware < kAlternatingSince) {
    if (!alternate) return Done{};
    return Error{ErrorCode::kBadData, "firmware " + version_->firmware.text() +
                                          " of the camera cannot alternate the emitter: update it "
                                          "to " +
                                          kAlternatingSince.text() +
                                          " or newer, or set drivers.camera.emitter: off"};
  }
  // This is sent in any case, to switch off what another program left on.
  const auto answer = AskMonitor(AlternatingEmitterRequest(alternate));
  if (!answer && alternate) return answer.error();
  return Done{};
}

Result<Done> Camera::SetControls() {
  // A failure is ignored: not every camera has this control, not every kernel takes every value,
  // and only flicker depends on it.
  (void)image_.video->SetControl(V4L2_CID_POWER_LINE_FREQUENCY,
                                 static_cast<int32_t>(config_.power_line));
  const bool automatic = config_.exposure == ExposureMode::kCamera;
  if (config_.source == CameraSource::kRealsense) {
    const auto answer = AskMonitor(VersionRequest());
    if (!answer) return answer.error();
    auto version = ParseVersion(*answer);
    if (!version) return version.error();
    version_ = std::move(*version);
    if (const auto done = SetEmitterMode(); !done) return done.error();
    if (const auto done = SetUnit(SetAutoExposure(automatic)); !done) return done.error();
  } else {
    const auto done = image_.video->SetControl(V4L2_CID_EXPOSURE_AUTO,
                                               automatic ? kAperturePriority : kManualExposure);
    if (!done && !automatic) return done.error();
  }
  if (config_.exposure != ExposureMode::kFixed) return Done{};
  return SetExposure({static_cast<uint32_t>(config_.exposure_us), config_.gain});
}

Result<Done> Camera::SetExposure(const ExposureSetting& setting) {
  if (config_.source == CameraSource::kRealsense) {
    if (const auto done = SetUnit(SetExposureUs(setting.exposure_us)); !done) return done.error();
    const auto done = control_node().SetControl(V4L2_CID_GAIN, setting.gain);
    if (!done) return done.error();
  } else {
    const auto units = static_cast<int32_t>(setting.exposure_us / kExposureUnitUs);
    const auto done = image_.video->SetControl(V4L2_CID_EXPOSURE_ABSOLUTE, units);
    if (!done) return done.error();
    (void)image_.video->SetControl(V4L2_CID_GAIN, setting.gain);
  }
  set_exposure_us_ = setting.exposure_us;
  return Done{};
}

Result<DepthCalibration> Camera::ReadCalibration() {
  if (config_.source != CameraSource::kRealsense) {
    return Error{ErrorCode::kInvalidArgument, "only a RealSense camera stores its calibration"};
  }
  const auto table = AskMonitor(CalibrationRequest(kDepthTableId));
  if (!table) return table.error();
  auto calibration = ParseDepthTable(*table, calibration_.width, calibration_.height);
  if (!calibration) return calibration.error();
  // Newer firmware tells the intrinsics that it rectifies with; older firmware does not know the
  // question.
  if (const auto rectified = AskMonitor({.opcode = Opcode::kRectified})) {
    const auto camera = FindRectified(*rectified, calibration_.width, calibration_.height);
    if (camera) calibration->camera = *camera;
  }
  return calibration;
}

Result<uint8_t> Camera::ReadDeviceError() {
  const auto value =
      control_node().GetUnitControl(kDepthUnit, static_cast<uint8_t>(Selector::kErrors));
  if (!value) return value.error();
  return value->empty() ? uint8_t{0} : value->front();
}

Result<Done> Camera::Start() {
  // Video starts before metadata, as in the software of the camera's maker.
  for (const Stream* stream : {&image_, &depth_}) {
    for (VideoNode* node : {stream->video.get(), stream->metadata.get()}) {
      if (node == nullptr) continue;
      if (const auto started = node->Start(); !started) return started.error();
    }
  }
  return Done{};
}

std::vector<int> Camera::fds() const {
  std::vector<int> out;
  for (const Stream* stream : {&image_, &depth_}) {
    if (stream->video) out.push_back(stream->video->fd());
    if (stream->metadata) out.push_back(stream->metadata->fd());
  }
  return out;
}

StreamState Camera::ReadVideo(Stream* stream, int64_t* lost, int64_t* bad,
                              std::vector<RawFrame>* out) {
  while (true) {
    Taken taken = stream->video->Take();
    if (taken.outcome == TakeOutcome::kNothing) return StreamState::kFine;
    if (taken.outcome == TakeOutcome::kBroken) return StreamState::kBroken;
    if (taken.outcome == TakeOutcome::kGone) return StreamState::kGone;
    const uint32_t expected = stream->sequence.value_or(taken.sequence - 1) + 1;
    const auto gap = static_cast<int32_t>(taken.sequence - expected);
    if (gap > 0) *lost += gap;
    stream->sequence = taken.sequence;
    if (taken.outcome == TakeOutcome::kBad) {
      ++*bad;
      continue;
    }
    RawFrame frame;
    frame.sequence = taken.sequence;
    frame.arrival = {taken.monotonic_us};
    frame.pixels = std::move(taken.bytes);
    for (RawFrame& done : stream->joiner->AddImage(std::move(frame)))
      out->push_back(std::move(done));
  }
}

StreamState Camera::ReadMetadata(Stream* stream, std::vector<RawFrame>* out) {
  while (true) {
    const Taken taken = stream->metadata->Take();
    if (taken.outcome == TakeOutcome::kNothing) return StreamState::kFine;
    if (taken.outcome == TakeOutcome::kBroken) return StreamState::kBroken;
    if (taken.outcome == TakeOutcome::kGone) return StreamState::kGone;
    const auto metadata = ParseMetadata(taken.bytes);
    if (taken.outcome == TakeOutcome::kBad || !metadata) {
      // The kernel gives an empty buffer when the camera repeats itself.
      if (!taken.bytes.empty()) ++counters_.metadata_bad;
      continue;
    }
    for (RawFrame& done : stream->joiner->AddMetadata(taken.sequence, *metadata)) {
      out->push_back(std::move(done));
    }
  }
}

void Camera::Collect(std::vector<RawFrame> images, std::vector<RawFrame> depths,
                     std::vector<CapturedFrame>* out) {
  const auto add = [out](std::optional<ImageAndDepth> pair) {
    if (pair) out->push_back({std::move(pair->image), std::move(pair->depth)});
  };
  for (RawFrame& image : images) {
    if (depth_.video)
      add(pairer_.AddImage(std::move(image)));
    else
      out->push_back({std::move(image), std::nullopt});
  }
  for (RawFrame& depth : depths) add(pairer_.AddDepth(std::move(depth)));
}

StreamState Camera::Read(int fd, std::vector<CapturedFrame>* out) {
  StreamState state = StreamState::kFine;
  std::vector<RawFrame> images, depths;
  if (fd == image_.video->fd()) {
    state = ReadVideo(&image_, &counters_.lost, &counters_.bad, &images);
    counters_.images += static_cast<int64_t>(images.size());
  } else if (image_.metadata && fd == image_.metadata->fd()) {
    state = ReadMetadata(&image_, &images);
    counters_.images += static_cast<int64_t>(images.size());
  } else if (depth_.video && fd == depth_.video->fd()) {
    state = ReadVideo(&depth_, &counters_.depth_lost, &counters_.depth_bad, &depths);
  } else if (depth_.metadata && fd == depth_.metadata->fd()) {
    state = ReadMetadata(&depth_, &depths);
  }
  Collect(std::move(images), std::move(depths), out);
  return state;
}

const StreamCounters& Camera::counters() {
  counters_.without_metadata = image_.joiner->without_metadata();
  counters_.unpaired = pairer_.unpaired();
  return counters_;
}

std::string Camera::text() const {
  std::string out = image_mode_.text() + " on " + image_.video->path();
  if (depth_.video) out += ", depth on " + depth_.video->path();
  return out + (d4xx_metadata_    ? ", full metadata"
                : image_.metadata ? ", times in metadata"
                                  : ", no metadata");
}

}  // namespace gw::camera

#include "drivers/camera/device/video_node.h"

#include <linux/usb/video.h>
#include <linux/uvcvideo.h>
#include <linux/videodev2.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

#include "common/core/format.h"
#include "drivers/camera/protocol/image_format.h"

namespace gw::camera {
namespace {

constexpr int kUnitTries = 20;

Error OpenError(const std::string& path, int error) {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return {ErrorCode::kNotFound, path + ": no such camera: plug it in"};
    case EACCES:
    case EPERM:
      return {
          ErrorCode::kIo,
          path + ": no permission: add this user to the group video, or install the udev rules"};
    default:
      return {ErrorCode::kIo, path + ": cannot open: " + std::strerror(error)};
  }
}

double RateOf(const v4l2_fract& interval) {
  return interval.numerator == 0 ? 0
                                 : static_cast<double>(interval.denominator) / interval.numerator;
}

}  // namespace

std::string VideoMode::text() const {
  return FourccName(fourcc) + " " + std::to_string(width) + "x" + std::to_string(height) + " at " +
         FormatFixed(rate_hz, rate_hz == std::floor(rate_hz) ? 0 : 2) + " Hz";
}

Result<VideoNode> VideoNode::Open(SystemCalls* calls, const std::string& path) {
  const int fd = calls->Open(path);
  if (fd < 0) return OpenError(path, -fd);
  v4l2_capability capability{};
  const int failed = calls->Ioctl(fd, VIDIOC_QUERYCAP, &capability);
  if (failed != 0) {
    calls->Close(fd);
    if (failed == -ENODEV) return OpenError(path, ENODEV);
    return Error{ErrorCode::kBadData, path + ": not a video device"};
  }
  const bool own = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0;
  return VideoNode(calls, fd, path, own ? capability.device_caps : capability.capabilities);
}

VideoNode::VideoNode(VideoNode&& other) noexcept
    : calls_(other.calls_),
      fd_(std::exchange(other.fd_, -1)),
      path_(std::move(other.path_)),
      capabilities_(other.capabilities_),
      image_bytes_(other.image_bytes_),
      started_(std::exchange(other.started_, false)),
      mappings_(std::exchange(other.mappings_, {})) {}

VideoNode::~VideoNode() {
  if (fd_ < 0) return;
  Stop();
  calls_->Close(fd_);
}

bool VideoNode::captures_video() const {
  return (capabilities_ & V4L2_CAP_VIDEO_CAPTURE) != 0;
}
bool VideoNode::captures_metadata() const {
  return (capabilities_ & V4L2_CAP_META_CAPTURE) != 0;
}
uint32_t VideoNode::buffer_type() const {
  return captures_video() ? V4L2_BUF_TYPE_VIDEO_CAPTURE : V4L2_BUF_TYPE_META_CAPTURE;
}

Error VideoNode::Failed(const std::string& what, int error) const {
  std::string advice;
  if (error == -EBUSY) advice = ": another program uses the camera; stop it";
  if (error == -ENOSPC) advice = ": not enough USB bandwidth; use another port, or a smaller mode";
  return {error == -ENODEV ? ErrorCode::kNotFound : ErrorCode::kIo,
          path_ + ": cannot " + what + ": " + std::strerror(-error) + advice};
}

std::vector<VideoMode> VideoNode::Modes() const {
  std::vector<VideoMode> out;
  v4l2_fmtdesc format{};
  format.type = buffer_type();
  for (; calls_->Ioctl(fd_, VIDIOC_ENUM_FMT, &format) == 0; ++format.index) {
    v4l2_frmsizeenum size{};
    size.pixel_format = format.pixelformat;
    for (; calls_->Ioctl(fd_, VIDIOC_ENUM_FRAMESIZES, &size) == 0; ++size.index) {
      const bool discrete = size.type == V4L2_FRMSIZE_TYPE_DISCRETE;
      v4l2_frmivalenum rate{};
      rate.pixel_format = format.pixelformat;
      rate.width = discrete ? size.discrete.width : size.stepwise.max_width;
      rate.height = discrete ? size.discrete.height : size.stepwise.max_height;
      for (; calls_->Ioctl(fd_, VIDIOC_ENUM_FRAMEINTERVALS, &rate) == 0; ++rate.index) {
        const bool listed = rate.type == V4L2_FRMIVAL_TYPE_DISCRETE;
        out.push_back({format.pixelformat, static_cast<int>(rate.width),
                       static_cast<int>(rate.height),
                       RateOf(listed ? rate.discrete : rate.stepwise.min)});
        if (!listed) break;
      }
      if (!discrete) break;
    }
  }
  return out;
}

bool VideoNode::Offers(uint32_t fourcc) const {
  v4l2_fmtdesc format{};
  format.type = buffer_type();
  for (; calls_->Ioctl(fd_, VIDIOC_ENUM_FMT, &format) == 0; ++format.index) {
    if (format.pixelformat == fourcc) return true;
  }
  return false;
}

Result<Done> VideoNode::SetMode(const VideoMode& mode) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  format.fmt.pix.width = static_cast<uint32_t>(mode.width);
  format.fmt.pix.height = static_cast<uint32_t>(mode.height);
  format.fmt.pix.pixelformat = mode.fourcc;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  if (const int failed = calls_->Ioctl(fd_, VIDIOC_S_FMT, &format); failed != 0) {
    return Failed("set " + mode.text(), failed);
  }
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  parameters.parm.capture.timeperframe = {1000,
                                          static_cast<uint32_t>(std::lround(1000 * mode.rate_hz))};
  if (const int failed = calls_->Ioctl(fd_, VIDIOC_S_PARM, &parameters); failed != 0) {
    return Failed("set " + mode.text(), failed);
  }
  // A driver changes what it cannot do and reports success, so that the answer has to be compared.
  const VideoMode got{format.fmt.pix.pixelformat, static_cast<int>(format.fmt.pix.width),
                      static_cast<int>(format.fmt.pix.height),
                      RateOf(parameters.parm.capture.timeperframe)};
  const size_t bytes = ImageBytes(got.fourcc, got.width, got.height);
  const bool padded = format.fmt.pix.bytesperline != 0 &&
                      format.fmt.pix.bytesperline * format.fmt.pix.height != bytes;
  if (got.fourcc != mode.fourcc || got.width != mode.width || got.height != mode.height ||
      std::abs(got.rate_hz - mode.rate_hz) > 0.02 * mode.rate_hz || padded) {
    return Error{ErrorCode::kBadData, path_ + ": wanted " + mode.text() + ", the camera gives " +
                                          got.text() + (padded ? " with padded rows" : "") +
                                          ": set calibration.camera to a mode that it has"};
  }
  image_bytes_ = bytes;
  return Done{};
}

Result<uint32_t> VideoNode::SetMetadataFormat(uint32_t fourcc) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_META_CAPTURE;
  format.fmt.meta.dataformat = fourcc;
  if (const int failed = calls_->Ioctl(fd_, VIDIOC_S_FMT, &format); failed != 0) {
    return Failed("set the metadata format", failed);
  }
  return uint32_t{format.fmt.meta.dataformat};
}

Result<Done> VideoNode::SetControl(uint32_t id, int32_t value) {
  v4l2_control control{id, value};
  const int failed = calls_->Ioctl(fd_, VIDIOC_S_CTRL, &control);
  if (failed == 0) return Done{};
  return Error{ErrorCode::kBadData,
               path_ + ": control " + std::to_string(id) + " refused: " + std::strerror(-failed)};
}

Result<Done> VideoNode::UnitQuery(uint8_t unit, uint8_t selector, uint8_t query,
                                  std::vector<uint8_t>* data) {
  uvc_xu_control_query request{};
  request.unit = unit;
  request.selector = selector;
  request.query = query;
  request.size = static_cast<uint16_t>(data->size());
  request.data = data->data();
  int failed = 0;
  for (int i = 0; i < kUnitTries; ++i) {
    failed = calls_->Ioctl(fd_, UVCIOC_CTRL_QUERY, &request);
    if (failed != -EIO && failed != -EAGAIN && failed != -EBUSY) break;
    calls_->Pause();
  }
  if (failed == 0) return Done{};
  return Failed("use control " + std::to_string(selector) + " of unit " + std::to_string(unit),
                failed);
}

Result<std::vector<uint8_t>> VideoNode::QueryUnitControl(uint8_t unit, uint8_t selector,
                                                         uint8_t query) {
  std::vector<uint8_t> length(2);
  if (const auto asked = UnitQuery(unit, selector, UVC_GET_LEN, &length); !asked) {
    return asked.error();
  }
  std::vector<uint8_t> value(static_cast<size_t>(length[0] | length[1] << 8));
  if (const auto got = UnitQuery(unit, selector, query, &value); !got) return got.error();
  return value;
}

Result<std::vector<uint8_t>> VideoNode::GetUnitControl(uint8_t unit, uint8_t selector) {
  return QueryUnitControl(unit, selector, UVC_GET_CUR);
}

Result<Done> VideoNode::SetUnitControl(uint8_t unit, uint8_t selector,
                                       std::span<const uint8_t> value) {
  std::vector<uint8_t> length(2);
  if (const auto asked = UnitQuery(unit, selector, UVC_GET_LEN, &length); !asked) {
    return asked.error();
  }
  const auto size = static_cast<size_t>(length[0] | length[1] << 8);
  if (size != value.size()) {
    return Error{ErrorCode::kBadData, path_ + ": control " + std::to_string(selector) + " has " +
                                          std::to_string(size) + " bytes, not " +
                                          std::to_string(value.size())};
  }
  std::vector<uint8_t> copy(value.begin(), value.end());
  return UnitQuery(unit, selector, UVC_SET_CUR, &copy);
}

Result<Done> VideoNode::MapBuffers() {
  v4l2_requestbuffers request{};
  request.count = kBuffers;
  request.type = buffer_type();
  request.memory = V4L2_MEMORY_MMAP;
  if (const int failed = calls_->Ioctl(fd_, VIDIOC_REQBUFS, &request); failed != 0) {
    return Failed("get buffers", failed);
  }
  for (uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer{};
    buffer.index = i;
    buffer.type = buffer_type();
    buffer.memory = V4L2_MEMORY_MMAP;
    if (const int failed = calls_->Ioctl(fd_, VIDIOC_QUERYBUF, &buffer); failed != 0) {
      return Failed("get buffers", failed);
    }
    uint8_t* memory = calls_->Map(fd_, buffer.length, buffer.m.offset);
    if (memory == nullptr) return Failed("map buffers", -errno);
    mappings_.push_back({memory, buffer.length});
    if (const int failed = calls_->Ioctl(fd_, VIDIOC_QBUF, &buffer); failed != 0) {
      return Failed("queue buffers", failed);
    }
  }
  return Done{};
}

void VideoNode::ReleaseBuffers() {
  for (const Mapping& mapping : mappings_) calls_->Unmap(mapping.memory, mapping.length);
  mappings_.clear();
  v4l2_requestbuffers none{};
  none.type = buffer_type();
  none.memory = V4L2_MEMORY_MMAP;
  (void)calls_->Ioctl(fd_, VIDIOC_REQBUFS, &none);
}

Result<Done> VideoNode::Start() {
  auto mapped = MapBuffers();
  if (mapped) {
    uint32_t type = buffer_type();
    const int failed = calls_->Ioctl(fd_, VIDIOC_STREAMON, &type);
    started_ = failed == 0;
    if (started_) return Done{};
    mapped = Failed("start the stream", failed);
  }
  ReleaseBuffers();
  return mapped.error();
}

void VideoNode::Stop() {
  if (!started_) return;
  started_ = false;
  uint32_t type = buffer_type();
  (void)calls_->Ioctl(fd_, VIDIOC_STREAMOFF, &type);
  ReleaseBuffers();
}

Taken VideoNode::Take() {
  Taken out;
  v4l2_buffer buffer{};
  buffer.type = buffer_type();
  buffer.memory = V4L2_MEMORY_MMAP;
  const int failed = calls_->Ioctl(fd_, VIDIOC_DQBUF, &buffer);
  if (failed == -EAGAIN) return out;
  if (failed != 0 || buffer.index >= mappings_.size()) {
    out.outcome = failed == -ENODEV ? TakeOutcome::kGone : TakeOutcome::kBroken;
    return out;
  }
  const Mapping& mapping = mappings_[buffer.index];
  const bool damaged = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0 ||
                       buffer.bytesused > mapping.length ||
                       (image_bytes_ != 0 && buffer.bytesused != image_bytes_);
  out.outcome = damaged ? TakeOutcome::kBad : TakeOutcome::kBuffer;
  out.sequence = buffer.sequence;
  out.monotonic_us = int64_t{buffer.timestamp.tv_sec} * 1'000'000 + buffer.timestamp.tv_usec;
  if (!damaged) out.bytes.assign(mapping.memory, mapping.memory + buffer.bytesused);
  const int queued = calls_->Ioctl(fd_, VIDIOC_QBUF, &buffer);
  if (queued != 0) {
    out.outcome = queued == -ENODEV ? TakeOutcome::kGone : TakeOutcome::kBroken;
  }
  return out;
}

}  // namespace gw::camera

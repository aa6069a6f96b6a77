#include "test/emulators/camera/emulated_camera.h"

#include <linux/usb/video.h>
#include <linux/uvcvideo.h>
#include <linux/videodev2.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "common/core/check.h"
#include "common/core/random.h"
#include "drivers/camera/protocol/depth_unit_controls.h"
#include "drivers/common/bytes.h"

namespace gw::camera {
namespace {

constexpr size_t kMetadataBytes = 10240;

std::vector<uint8_t> Interleave(const std::vector<uint8_t>& left,
                                const std::vector<uint8_t>& right) {
  std::vector<uint8_t> out(2 * left.size());
  for (size_t i = 0; i < left.size(); ++i) {
    out[2 * i] = left[i];
    out[2 * i + 1] = right[i];
  }
  return out;
}

std::vector<uint8_t> U16(uint32_t value) {
  std::vector<uint8_t> out;
  AppendU16(static_cast<uint16_t>(value), &out);
  return out;
}
std::vector<uint8_t> U32(uint32_t value) {
  std::vector<uint8_t> out;
  AppendU32(value, &out);
  return out;
}

bool TakeOne(int* count) {
  if (*count == 0) return false;
  --*count;
  return true;
}

}  // namespace

EmulatedCamera::EmulatedCamera(const EmulatedCameraConfig& config, Scene scene)
    : config_(config), scene_(std::move(scene)) {
  const Role roles[] = {Role::kDepth, Role::kInfrared, Role::kColour};
  for (size_t i = 0; i < nodes_.size(); ++i) {
    nodes_[i].role = roles[i / 2];
    nodes_[i].metadata = i % 2 == 1;
  }
}

void EmulatedCamera::WakeAll() {
  for (const auto& [fd, node] : open_) {
    const uint64_t one = 1;
    (void)!::write(fd, &one, sizeof(one));
  }
}

void EmulatedCamera::FailStream() {
  stream_error_ = true;
  WakeAll();
}

void EmulatedCamera::Unplug() {
  plugged_ = false;
  WakeAll();
}

int64_t EmulatedCamera::EndOfExposureUs(int64_t frame) const {
  return config_.start_us + frame * 1'000'000 / config_.rate_hz;
}

int64_t EmulatedCamera::MidExposureUs(int64_t frame) const {
  return EndOfExposureUs(frame) - exposure_us() / 2;
}

void EmulatedCamera::AdvanceTo(int64_t monotonic_us) {
  for (; EndOfExposureUs(frame_) <= monotonic_us; ++frame_) {
    CounterRng rng(config_.seed, 1, static_cast<uint64_t>(frame_));
    const auto wait =
        static_cast<int64_t>(-static_cast<double>(config_.jitter_us) * std::log(1 - rng.Uniform()));
    const bool lit = emitter_ && (!alternating_ || frame_ % 2 == 1);
    int64_t at_us = EndOfExposureUs(frame_) + config_.delay_us + wait;
    if (!deliveries_.empty()) at_us = std::max(at_us, deliveries_.back().at_us);
    deliveries_.push_back({at_us, frame_, lit, exposure_us()});
  }
  while (!deliveries_.empty() && deliveries_.front().at_us <= monotonic_us) {
    if (plugged_ && !silent_) Deliver(deliveries_.front());
    deliveries_.pop_front();
  }
}

FrameMetadata EmulatedCamera::MetadataOf(const Delivery& delivery) const {
  const int64_t since_start = EndOfExposureUs(delivery.frame) - config_.start_us;
  FrameMetadata out;
  out.host_ns = delivery.at_us * 1000;
  out.pts_us = config_.first_pts_us +
               static_cast<uint32_t>(
                   std::llround(static_cast<double>(since_start) * (1 + config_.clock_ppm * 1e-6)));
  out.frame_counter = static_cast<uint32_t>(delivery.frame);
  out.to_mid_exposure_us = delivery.exposure_us / 2;
  out.exposure_us = delivery.exposure_us;
  out.gain = static_cast<uint32_t>(gain_);
  out.laser_power_mw = laser_power_mw_;
  out.emitter_on = delivery.emitter_on;
  return out;
}

void EmulatedCamera::Deliver(const Delivery& delivery) {
  const EmulatedScene scene = scene_(delivery.frame, delivery.emitter_on);
  const bool lost = TakeOne(&lose_);
  const bool no_metadata = TakeOne(&lose_metadata_);
  for (Node& node : nodes_) {
    if (!node.streaming) continue;
    const uint32_t sequence = node.sequence++;
    if (lost || (node.metadata && no_metadata)) continue;
    std::vector<uint8_t> bytes;
    if (node.metadata) {
      bytes = EncodeMetadata(MetadataOf(delivery), node.format == kMetaD4xx);
    } else if (node.format == kY8i) {
      bytes = Interleave(scene.left, scene.right);
    } else if (node.format == kGrey) {
      bytes = scene.left;
    } else if (node.format == kZ16) {
      for (const uint16_t mm : scene.depth) AppendU16(mm, &bytes);
    }
    if (node.queued.empty()) continue;  // the driver is late and has given no buffer back
    Fill(&node, bytes, delivery.at_us);
    Buffer& buffer = node.buffers[node.filled.back()];
    buffer.sequence = sequence;
    if (!node.metadata && damage_ > 0) buffer.flags |= V4L2_BUF_FLAG_ERROR;
    if (!node.metadata && shorten_ > 0) buffer.used -= 100;
  }
  TakeOne(&damage_);
  TakeOne(&shorten_);
}

void EmulatedCamera::Fill(Node* node, const std::vector<uint8_t>& bytes, int64_t time_us) {
  const uint32_t index = node->queued.front();
  node->queued.pop_front();
  Buffer& buffer = node->buffers[index];
  GW_CHECK(bytes.size() <= buffer.memory.size());
  std::copy(bytes.begin(), bytes.end(), buffer.memory.begin());
  buffer.used = bytes.size();
  buffer.flags = 0;
  buffer.time_us = time_us;
  node->filled.push_back(index);
  const uint64_t one = 1;
  (void)!::write(node->event_fd, &one, sizeof(one));
}

int EmulatedCamera::Open(const std::string& path) {
  const std::string prefix = config_.dev + "/video";
  if (!plugged_ || path.rfind(prefix, 0) != 0) return -ENOENT;
  const int number = std::stoi(path.substr(prefix.size())) - config_.first_node;
  if (number < 0 || number >= static_cast<int>(nodes_.size())) return -ENOENT;
  Node& node = nodes_[static_cast<size_t>(number)];
  node.event_fd = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  open_[node.event_fd] = &node;
  return node.event_fd;
}

void EmulatedCamera::Close(int fd) {
  Node* node = open_.at(fd);
  node->streaming = false;
  node->buffers.clear();
  node->queued.clear();
  node->filled.clear();
  open_.erase(fd);
  ::close(fd);
}

std::vector<uint32_t> EmulatedCamera::Formats(const Node& node) const {
  if (node.metadata) return {kMetaUvc};
  switch (node.role) {
    case Role::kDepth:
      return {kZ16};
    case Role::kInfrared:
      if (!config_.has_y8i) return {kGrey, Fourcc('U', 'Y', 'V', 'Y')};
      return {kGrey, Fourcc('U', 'Y', 'V', 'Y'), kY8i, Fourcc('Y', '1', '2', 'I')};
    case Role::kColour:
      return {kYuyv};
  }
  return {};
}

int EmulatedCamera::EnumerateFormat(const Node& node, void* argument) const {
  auto* format = static_cast<v4l2_fmtdesc*>(argument);
  const auto formats = Formats(node);
  if (format->index >= formats.size()) return -EINVAL;
  format->pixelformat = formats[format->index];
  return 0;
}

int EmulatedCamera::EnumerateSize(const Node& node, void* argument) const {
  auto* size = static_cast<v4l2_frmsizeenum*>(argument);
  if (size->index > 0 || node.metadata) return -EINVAL;
  size->type = V4L2_FRMSIZE_TYPE_DISCRETE;
  size->discrete = {static_cast<uint32_t>(config_.width), static_cast<uint32_t>(config_.height)};
  return 0;
}

int EmulatedCamera::EnumerateRate(const Node& node, void* argument) const {
  auto* rate = static_cast<v4l2_frmivalenum*>(argument);
  if (rate->index > 0 || node.metadata) return -EINVAL;
  rate->type = V4L2_FRMIVAL_TYPE_DISCRETE;
  rate->discrete = {1, static_cast<uint32_t>(config_.rate_hz)};
  return 0;
}

// Sets a format as uvcvideo does: what it cannot do it changes, and reports success.
int EmulatedCamera::SetFormat(Node* node, void* argument) const {
  auto* format = static_cast<v4l2_format*>(argument);
  if (!node->buffers.empty()) return -EBUSY;
  if (node->metadata) {
    const bool known = format->fmt.meta.dataformat == kMetaD4xx && config_.d4xx_metadata;
    node->format = known ? kMetaD4xx : kMetaUvc;
    format->fmt.meta.dataformat = node->format;
    return 0;
  }
  const auto formats = Formats(*node);
  const bool known =
      std::find(formats.begin(), formats.end(), format->fmt.pix.pixelformat) != formats.end();
  node->format = known ? format->fmt.pix.pixelformat : formats.front();
  format->fmt.pix.pixelformat = node->format;
  format->fmt.pix.width = static_cast<uint32_t>(config_.width);
  format->fmt.pix.height = static_cast<uint32_t>(config_.height);
  format->fmt.pix.bytesperline = format->fmt.pix.width * (node->format == kGrey ? 1 : 2);
  return 0;
}

int EmulatedCamera::RequestBuffers(Node* node, void* argument) {
  auto* request = static_cast<v4l2_requestbuffers*>(argument);
  if (node->streaming) return -EBUSY;
  node->buffers.clear();
  node->queued.clear();
  node->filled.clear();
  const size_t bytes =
      node->metadata ? kMetadataBytes : ImageBytes(node->format, config_.width, config_.height);
  for (uint32_t i = 0; i < request->count; ++i) {
    node->buffers.emplace_back();
    node->buffers.back().memory.resize(bytes);
  }
  return 0;
}

int EmulatedCamera::StartStream(Node* node) {
  if (!node->metadata && TakeOne(&refuse_start_)) return -EPROTO;
  node->streaming = true;
  node->sequence = 0;
  stream_error_ = false;
  return 0;
}

int EmulatedCamera::TakeBuffer(Node* node, void* argument) {
  if (!node->streaming) return -EINVAL;
  if (stream_error_) return -EIO;
  if (node->filled.empty()) return -EAGAIN;
  const uint32_t index = node->filled.front();
  node->filled.pop_front();
  if (node->filled.empty()) {
    uint64_t count = 0;
    (void)!::read(node->event_fd, &count, sizeof(count));
  }
  const Buffer& from = node->buffers[index];
  auto* buffer = static_cast<v4l2_buffer*>(argument);
  buffer->index = index;
  buffer->bytesused = static_cast<uint32_t>(from.used);
  buffer->flags = from.flags | V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  buffer->sequence = from.sequence;
  buffer->timestamp = {from.time_us / 1'000'000, from.time_us % 1'000'000};
  return 0;
}

int EmulatedCamera::Ioctl(int fd, uint64_t request, void* argument) {
  const auto place = open_.find(fd);
  if (place == open_.end()) return -EBADF;
  if (!plugged_) return -ENODEV;
  Node* node = place->second;
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto* capability = static_cast<v4l2_capability*>(argument);
      capability->capabilities = V4L2_CAP_DEVICE_CAPS | V4L2_CAP_VIDEO_CAPTURE |
                                 V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
      capability->device_caps =
          V4L2_CAP_STREAMING | (node->metadata ? V4L2_CAP_META_CAPTURE : V4L2_CAP_VIDEO_CAPTURE);
      return 0;
    }
    case VIDIOC_ENUM_FMT:
      return EnumerateFormat(*node, argument);
    case VIDIOC_ENUM_FRAMESIZES:
      return EnumerateSize(*node, argument);
    case VIDIOC_ENUM_FRAMEINTERVALS:
      return EnumerateRate(*node, argument);
    case VIDIOC_S_FMT:
      return SetFormat(node, argument);
    case VIDIOC_S_PARM:
      static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe = {
          1, static_cast<uint32_t>(config_.rate_hz)};
      return 0;
    case VIDIOC_S_CTRL: {
      const auto* control = static_cast<v4l2_control*>(argument);
      if (control->id != V4L2_CID_GAIN || node->role != Role::kDepth) return -EINVAL;
      gain_ = control->value;
      return 0;
    }
    case VIDIOC_REQBUFS:
      return RequestBuffers(node, argument);
    case VIDIOC_QUERYBUF: {
      auto* buffer = static_cast<v4l2_buffer*>(argument);
      buffer->length = static_cast<uint32_t>(node->buffers.at(buffer->index).memory.size());
      buffer->m.offset = buffer->index * 4096;
      return 0;
    }
    case VIDIOC_QBUF:
      node->queued.push_back(static_cast<v4l2_buffer*>(argument)->index);
      return 0;
    case VIDIOC_DQBUF:
      return TakeBuffer(node, argument);
    case VIDIOC_STREAMON:
      return StartStream(node);
    case VIDIOC_STREAMOFF:
      node->streaming = false;
      return 0;
    case UVCIOC_CTRL_QUERY:
      return node->role == Role::kDepth ? UnitControl(argument) : -ENOENT;
    default:
      return -ENOTTY;
  }
}

uint8_t* EmulatedCamera::Map(int fd, size_t length, int64_t offset) {
  Buffer& buffer = open_.at(fd)->buffers.at(static_cast<size_t>(offset / 4096));
  GW_CHECK(length == buffer.memory.size());
  ++mapped_;
  return buffer.memory.data();
}

void EmulatedCamera::Unmap(uint8_t* /*memory*/, size_t /*length*/) {
  --mapped_;
}

std::vector<uint8_t> EmulatedCamera::UnitValue(uint8_t selector, uint8_t query) const {
  switch (static_cast<Selector>(selector)) {
    case Selector::kMonitor:
      return query == UVC_GET_CUR ? monitor_answer_ : std::vector<uint8_t>(kMonitorBytes);
    case Selector::kEmitter:
      return {static_cast<uint8_t>(emitter_)};
    case Selector::kExposure:
      return U32(exposure_us_);
    case Selector::kLaserPower:
      return U16(query == UVC_GET_MIN   ? 0
                 : query == UVC_GET_MAX ? 360
                 : query == UVC_GET_RES ? 30
                                        : laser_power_mw_);
    case Selector::kErrors:
      return {device_error_};
    case Selector::kTemperature:
      return {1, 1, 40, 42};
    case Selector::kAutoExposure:
      return {static_cast<uint8_t>(auto_exposure_)};
  }
  return {};
}

void EmulatedCamera::SetUnitValue(uint8_t selector, const std::vector<uint8_t>& value) {
  switch (static_cast<Selector>(selector)) {
    case Selector::kMonitor:
      return AnswerMonitor(value);
    case Selector::kEmitter:
      emitter_ = value[0] != 0;
      return;
    case Selector::kExposure:
      exposure_us_ = ReadU32(value, 0);
      return;
    case Selector::kLaserPower:
      laser_power_mw_ = ReadU16(value, 0);
      return;
    case Selector::kAutoExposure:
      auto_exposure_ = value[0] != 0;
      return;
    default:
      return;
  }
}

int EmulatedCamera::UnitControl(void* argument) {
  auto* query = static_cast<uvc_xu_control_query*>(argument);
  if (query->unit != kDepthUnit) return -ENOENT;
  if (TakeOne(&refuse_unit_)) return -EIO;
  const std::vector<uint8_t> value = UnitValue(query->selector, query->query);
  if (value.empty()) return -ENOENT;
  if (query->query == UVC_GET_LEN) {
    if (query->size != 2) return -ENOBUFS;
    query->data[0] = static_cast<uint8_t>(value.size() & 0xFF);
    query->data[1] = static_cast<uint8_t>(value.size() >> 8);
    return 0;
  }
  if (query->size != value.size()) return -ENOBUFS;
  if (query->query == UVC_SET_CUR) {
    SetUnitValue(query->selector, {query->data, query->data + query->size});
  } else {
    std::copy(value.begin(), value.end(), query->data);
  }
  return 0;
}

void EmulatedCamera::AnswerMonitor(const std::vector<uint8_t>& request) {
  const auto opcode = static_cast<int32_t>(ReadU32(request, 4));
  const uint32_t parameter = ReadU32(request, 8);
  if (ReadU16(request, 2) != 0xCDAB) {
    monitor_answer_ = EncodeAnswer(-1, {});
  } else if (opcode == static_cast<int32_t>(Opcode::kVersion)) {
    monitor_answer_ = EncodeAnswer(opcode, EncodeVersion(config_.firmware, "a1b2c3d4e5f6"));
  } else if (opcode == static_cast<int32_t>(Opcode::kCalibrationTable) &&
             parameter == kDepthTableId) {
    monitor_answer_ = EncodeAnswer(opcode, EncodeDepthTable(config_.calibration));
  } else if (opcode == static_cast<int32_t>(Opcode::kSubPreset)) {
    alternating_ = parameter > 0;
    monitor_answer_ = EncodeAnswer(opcode, {});
  } else {
    monitor_answer_ = EncodeAnswer(-1, {});
  }
}

}  // namespace gw::camera

// CAMERA: the one message too large to copy without need.
#include <gw_lcm/camera_image_t.hpp>
#include <gw_lcm/camera_t.hpp>

#include "common/wire/archive.h"

namespace gw::wire {
namespace {

using ImageType = gw_lcm::camera_image_t;
static_assert(ImageType::FORMAT_GRAY8 == static_cast<int>(PixelFormat::kGray8));
static_assert(ImageType::FORMAT_DEPTH16 == static_cast<int>(PixelFormat::kDepth16));
static_assert(gw_lcm::camera_t::EMITTER_OFF == static_cast<int>(EmitterState::kOff));
static_assert(gw_lcm::camera_t::EMITTER_ON == static_cast<int>(EmitterState::kOn));

constexpr int kMaxSidePx = 8192;
constexpr int64_t kMaxStrideBytes = 4 * kMaxSidePx;  // padding beyond this is no padding
constexpr size_t kImageHeaderBytes = 24;

template <typename A>
void FrameFields(A& a, typename A::template Of<CameraFrame>& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  a.Int32("exposure_us", m.exposure_us, 0, std::numeric_limits<int32_t>::max());
  Enum(a, "emitter", m.emitter, static_cast<int32_t>(EmitterState::kOn));
}

template <typename A>
void ImageFields(A& a, typename A::template Of<int32_t>& kind,
                 typename A::template Of<ImageView>& image) {
  a.Int32("images.kind", kind, ImageType::KIND_LEFT, ImageType::KIND_DEPTH);
  a.Int32("images.width", image.width, 1, kMaxSidePx);
  a.Int32("images.height", image.height, 1, kMaxSidePx);
  a.Int32("images.row_stride", image.stride, 1, kMaxStrideBytes);
  a.Int32("images.pixel_format", image.format, ImageType::FORMAT_GRAY8, ImageType::FORMAT_DEPTH16);
}

void WriteImage(Writer& a, int32_t kind, const ImageView& image) {
  ImageView tight = image;
  tight.stride = image.width * BytesPerPixel(image.format);
  ImageFields(a, kind, tight);
  a.Int32("images.size", tight.stride * tight.height, 0, 0);
  for (int row = 0; row < image.height; ++row) {
    a.Raw(image.data + static_cast<ptrdiff_t>(row) * image.stride, tight.stride);
  }
}

// The pixels of `image` point into the message.
void ReadImage(Reader& a, int32_t& kind, ImageView& image) {
  ImageFields(a, kind, image);
  int32_t size = 0;
  a.Int32("images.size", size, 1, std::numeric_limits<int32_t>::max());
  a.Rule("images.row_stride", "shorter than a row",
         image.stride >= image.width * BytesPerPixel(image.format));
  a.Rule("images.size", "not row_stride * height",
         size == static_cast<int64_t>(image.stride) * image.height);
  image.data = a.Raw(size).data();
}

// The pixels of the frame point into the message.
Result<CameraFrame> ReadFrame(ByteSpan message) {
  CameraFrame frame;
  Reader reader("camera_t", gw_lcm::camera_t::getHash(), message);
  FrameFields(reader, frame);
  int32_t count = 0;
  reader.Int32("num_images", count, 1, 3);
  for (int32_t i = 0; i < count; ++i) {
    int32_t kind = 0;
    ImageView image;
    ReadImage(reader, kind, image);
    if (!reader.ok()) break;
    ImageView& slot = kind == ImageType::KIND_LEFT    ? frame.left
                      : kind == ImageType::KIND_RIGHT ? frame.right
                                                      : frame.depth;
    reader.Rule("images.kind", "there twice", slot.empty());
    reader.Rule("images.pixel_format", "not that of its kind",
                image.format ==
                    (kind == ImageType::KIND_DEPTH ? PixelFormat::kDepth16 : PixelFormat::kGray8));
    slot = image;
  }
  reader.End();
  reader.Rule("images", "without a left one", !frame.left.empty());
  for (const ImageView* other : {&frame.right, &frame.depth}) {
    reader.Rule(
        "images", "of different sizes",
        other->empty() || (other->width == frame.left.width && other->height == frame.left.height));
  }
  reader.Rule("images.row_stride", "odd in a depth image", frame.depth.stride % 2 == 0);
  if (!reader.ok()) return reader.error();
  return frame;
}

bool IsOdd(const uint8_t* place) {
  return reinterpret_cast<uintptr_t>(place) % 2 != 0;
}

}  // namespace

Bytes Encode(const CameraFrame& frame) {
  GW_CHECK(!frame.left.empty());
  const std::pair<int32_t, const ImageView*> images[] = {{ImageType::KIND_LEFT, &frame.left},
                                                         {ImageType::KIND_RIGHT, &frame.right},
                                                         {ImageType::KIND_DEPTH, &frame.depth}};
  size_t reserve = 64;
  int32_t count = 0;
  for (const auto& [kind, image] : images) {
    if (image->empty()) continue;
    ++count;
    reserve += kImageHeaderBytes +
               static_cast<size_t>(image->width) * image->height * BytesPerPixel(image->format);
  }
  Writer writer(gw_lcm::camera_t::getHash(), reserve);
  FrameFields(writer, frame);
  writer.Int32("num_images", count, 0, 0);
  for (const auto& [kind, image] : images) {
    if (!image->empty()) WriteImage(writer, kind, *image);
  }
  return std::move(writer).Take();
}

Result<DecodedCamera> DecodeCamera(Bytes message) {
  DecodedCamera result;
  result.storage = std::move(message);
  const auto frame = ReadFrame(result.storage);
  if (!frame) return frame.error();
  result.frame = *frame;
  // Depth behind an image of odd size starts at an odd place: move it over the header before it.
  ImageView& depth = result.frame.depth;
  if (IsOdd(depth.data)) {
    uint8_t* begin = result.storage.data() + (depth.data - result.storage.data());
    std::memmove(begin - 1, begin, static_cast<size_t>(depth.stride) * depth.height);
    depth.data = begin - 1;
  }
  return result;
}

Result<DecodedCamera> ViewCamera(ByteSpan message) {
  const auto frame = ReadFrame(message);
  if (!frame) return frame.error();
  if (IsOdd(frame->depth.data)) return DecodeCamera(Bytes(message.begin(), message.end()));
  DecodedCamera result;
  result.frame = *frame;
  return result;
}

template <>
Result<DecodedCamera> Decode(ByteSpan message) {
  return DecodeCamera(Bytes(message.begin(), message.end()));
}

}  // namespace gw::wire

#include "tools/data/import/ros_images.h"

#include <array>
#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "tools/data/import/image_file.h"

namespace gw::importer {
namespace {

constexpr const char* kRaw = "sensor_msgs/Image";
constexpr const char* kCompressed = "sensor_msgs/CompressedImage";
constexpr int kLargestSide = 16384;  // px

Error Refused(const std::string& what) {
  return {ErrorCode::kBadData, what};
}

struct RawImage {
  int width = 0, height = 0;
  std::string encoding;
  bool big_endian = false;
  size_t step = 0;
  bag::Bytes data;

  // Where a row begins.
  const uint8_t* Row(int y) const { return data.data() + static_cast<size_t>(y) * step; }
};

Result<RawImage> ReadRaw(const RosMessage& message) {
  RosReader reader(message);
  reader.ReadHeader();
  RawImage image;
  const auto height = reader.Read<uint32_t>();
  const auto width = reader.Read<uint32_t>();
  image.encoding = reader.Text();
  image.big_endian = reader.Read<uint8_t>() != 0;
  image.step = reader.Read<uint32_t>();
  image.data = reader.Array();
  if (!reader.ok()) return Refused("image message is shorter than its type");
  if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide) {
    return Refused("image message has an implausible size");
  }
  image.width = static_cast<int>(width);
  image.height = static_cast<int>(height);
  return image;
}

struct CompressedImage {
  std::string format;
  bag::Bytes data;
};

Result<CompressedImage> ReadCompressed(const RosMessage& message) {
  RosReader reader(message);
  reader.ReadHeader();
  CompressedImage image;
  image.format = reader.Text();
  image.data = reader.Array();
  if (!reader.ok()) return Refused("compressed image message is shorter than its type");
  return image;
}

// True when rows of this many bytes per pixel are really there.
bool Fits(const RawImage& image, size_t pixel_bytes) {
  const size_t row = static_cast<size_t>(image.width) * pixel_bytes;
  return image.step >= row &&
         image.data.size() >= image.step * (static_cast<size_t>(image.height) - 1) + row;
}

Image Allocate(int width, int height, PixelFormat format) {
  Image image;
  image.width = width;
  image.height = height;
  image.format = format;
  image.bytes.resize(static_cast<size_t>(width) * static_cast<size_t>(height) *
                     static_cast<size_t>(BytesPerPixel(format)));
  return image;
}

Image CopyRows(const RawImage& raw, PixelFormat format) {
  Image image = Allocate(raw.width, raw.height, format);
  const size_t row = image.bytes.size() / static_cast<size_t>(raw.height);
  for (int y = 0; y < raw.height; ++y) {
    std::memcpy(image.bytes.data() + static_cast<size_t>(y) * row, raw.Row(y), row);
  }
  return image;
}

// How the bytes of a pixel become one byte of grey.
struct GreyLayout {
  const char* encoding;
  int pixel_bytes;
  int red, green, blue;  // positions of the colours; red < 0: the byte at `green` is the grey
};
constexpr std::array<GreyLayout, 14> kGreyLayouts = {{{"mono8", 1, -1, 0, 0},
                                                      {"8UC1", 1, -1, 0, 0},
                                                      {"mono16", 2, -1, 1, 0},
                                                      {"16UC1", 2, -1, 1, 0},
                                                      {"rgb8", 3, 0, 1, 2},
                                                      {"bgr8", 3, 2, 1, 0},
                                                      {"8UC3", 3, 2, 1, 0},
                                                      {"rgba8", 4, 0, 1, 2},
                                                      {"bgra8", 4, 2, 1, 0},
                                                      {"8UC4", 4, 2, 1, 0},
                                                      {"yuv422", 2, -1, 1, 0},
                                                      {"uyvy", 2, -1, 1, 0},
                                                      {"yuv422_yuy2", 2, -1, 0, 0},
                                                      {"yuyv", 2, -1, 0, 0}}};

Image GreyByLayout(const RawImage& raw, const GreyLayout& layout) {
  Image image = Allocate(raw.width, raw.height, PixelFormat::kGray8);
  image.converted = layout.pixel_bytes > 1;
  // The upper byte comes first where the sender says so.
  const bool sixteen = raw.encoding == "mono16" || raw.encoding == "16UC1";
  const int grey = sixteen && raw.big_endian ? 0 : layout.green;
  auto out = image.bytes.begin();
  for (int y = 0; y < raw.height; ++y) {
    const uint8_t* pixel = raw.Row(y);
    for (int x = 0; x < raw.width; ++x, pixel += layout.pixel_bytes) {
      *out++ = layout.red < 0 ? pixel[grey]
                              : GreyOf(pixel[layout.red], pixel[layout.green], pixel[layout.blue]);
    }
  }
  return image;
}

Image GreyOfBgr(const cv::Mat& pixels) {
  Image image = Allocate(pixels.cols, pixels.rows, PixelFormat::kGray8);
  image.converted = true;
  auto out = image.bytes.begin();
  const int channels = pixels.channels();
  for (int y = 0; y < pixels.rows; ++y) {
    const uint8_t* pixel = pixels.ptr<uint8_t>(y);
    for (int x = 0; x < pixels.cols; ++x, pixel += channels) {
      *out++ = channels == 1 ? *pixel : GreyOf(pixel[2], pixel[1], pixel[0]);
    }
  }
  return image;
}

// ROS names a Bayer pattern by its first two rows, OpenCV by the second row's second and third
// pixel.
std::optional<int> BayerConversion(const std::string& encoding) {
  if (encoding == "bayer_rggb8") return cv::COLOR_BayerBG2BGR;
  if (encoding == "bayer_bggr8") return cv::COLOR_BayerRG2BGR;
  if (encoding == "bayer_gbrg8") return cv::COLOR_BayerGR2BGR;
  if (encoding == "bayer_grbg8") return cv::COLOR_BayerGB2BGR;
  return std::nullopt;
}

Result<Image> GreyOfRaw(const RawImage& raw) {
  const Error too_short = Refused("image message holds fewer pixels than its size");
  for (const GreyLayout& layout : kGreyLayouts) {
    if (raw.encoding != layout.encoding) continue;
    if (!Fits(raw, static_cast<size_t>(layout.pixel_bytes))) return too_short;
    return GreyByLayout(raw, layout);
  }
  const std::optional<int> bayer = BayerConversion(raw.encoding);
  if (!bayer) {
    return Refused("image encoding is '" + raw.encoding +
                   "'; mono8, mono16, 8UC1, rgb8, bgr8, rgba8, bgra8, yuv422 and 8-bit bayer can "
                   "be imported");
  }
  if (!Fits(raw, 1)) return too_short;
  if (raw.width < 4 || raw.height < 4) return Refused("bayer image is too small");
  // cv::Mat has no view of constant pixels; they are not written.
  const cv::Mat pattern(raw.height, raw.width, CV_8UC1, const_cast<uint8_t*>(raw.data.data()),
                        raw.step);
  cv::Mat bgr;
  cv::cvtColor(pattern, bgr, *bayer);
  return GreyOfBgr(bgr);
}

Result<cv::Mat> Unpack(bag::Bytes data, const std::string& format) {
  try {
    if (!data.empty() && data.size() < INT32_MAX) {
      const cv::Mat in(1, static_cast<int>(data.size()), CV_8UC1,
                       const_cast<uint8_t*>(data.data()));
      cv::Mat pixels = cv::imdecode(in, cv::IMREAD_UNCHANGED);
      if (!pixels.empty()) return pixels;
    }
  } catch (const cv::Exception&) {
    // Same answer as for an empty image.
  }
  return Refused("compressed image (" + format + ") cannot be decoded");
}

template <typename Pixels>
Image DepthOf(int width, int height, double depth_unit_m, Pixels metres_at) {
  Image image = Allocate(width, height, PixelFormat::kDepth16);
  image.converted = true;
  uint8_t* out = image.bytes.data();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x, out += 2) {
      const double units = std::round(static_cast<double>(metres_at(x, y)) / depth_unit_m);
      const bool usable = units > 0 && units <= 65535;  // false for NaN
      const uint16_t value = usable ? static_cast<uint16_t>(units) : 0;
      std::memcpy(out, &value, 2);
    }
  }
  return image;
}

Result<Image> DepthOfRaw(const RawImage& raw, double depth_unit_m) {
  const bool metres = raw.encoding == "32FC1";
  if (!metres && raw.encoding != "16UC1" && raw.encoding != "mono16") {
    return Refused("image encoding is '" + raw.encoding +
                   "'; depth of 16UC1, mono16 and 32FC1 can be imported");
  }
  if (raw.big_endian) return Refused("big-endian depth is not supported");
  if (!Fits(raw, metres ? 4 : 2)) return Refused("image message holds fewer pixels than its size");
  if (!metres) return CopyRows(raw, PixelFormat::kDepth16);
  return DepthOf(raw.width, raw.height, depth_unit_m, [&](int x, int y) {
    float depth_m = 0;
    std::memcpy(&depth_m, raw.Row(y) + 4 * static_cast<size_t>(x), 4);
    return depth_m;
  });
}

Result<Image> DepthOfCompressed(const CompressedImage& image, double depth_unit_m) {
  constexpr size_t kConfiguration = 12;  // int32 format, float A, float B
  if (image.format.find("compressedDepth") == std::string::npos || image.data.size() < 12) {
    return Refused("compressed image is '" + image.format + "'; depth must be compressedDepth");
  }
  if (image.format.find("rvl") != std::string::npos) {
    return Refused("depth is compressed as RVL, which is not supported; record it as PNG");
  }
  float a = 0, b = 0;
  std::memcpy(&a, image.data.data() + 4, 4);
  std::memcpy(&b, image.data.data() + 8, 4);
  const Result<cv::Mat> pixels = Unpack(image.data.subspan(kConfiguration), image.format);
  if (!pixels) return pixels.error();
  if (pixels->type() != CV_16UC1) return Refused("compressed depth is not 16-bit");
  if (image.format.starts_with("32FC1")) {
    return DepthOf(pixels->cols, pixels->rows, depth_unit_m, [&](int x, int y) {
      const uint16_t value = pixels->at<uint16_t>(y, x);
      return value == 0 ? 0.f : a / (static_cast<float>(value) - b);
    });
  }
  Image out = Allocate(pixels->cols, pixels->rows, PixelFormat::kDepth16);
  for (int y = 0; y < pixels->rows; ++y) {
    const size_t row = static_cast<size_t>(pixels->cols) * 2;
    std::memcpy(out.bytes.data() + static_cast<size_t>(y) * row, pixels->ptr(y), row);
  }
  return out;
}

}  // namespace

bool IsImageType(const std::string& type) {
  return type == kRaw || type == kCompressed;
}

Result<std::string> DecodeRosEncoding(const RosMessage& message, const std::string& type) {
  if (type == kCompressed) {
    const Result<CompressedImage> image = ReadCompressed(message);
    if (!image) return image.error();
    return image->format;
  }
  const Result<RawImage> image = ReadRaw(message);
  if (!image) return image.error();
  return image->encoding;
}

bool IsDepthEncoding(const std::string& encoding) {
  return encoding == "16UC1" || encoding == "32FC1" ||
         encoding.find("compressedDepth") != std::string::npos;
}

Result<Image> DecodeRosGrey(const RosMessage& message, const std::string& type) {
  if (type == kCompressed) {
    const Result<CompressedImage> image = ReadCompressed(message);
    if (!image) return image.error();
    const Result<cv::Mat> pixels = Unpack(image->data, image->format);
    if (!pixels) return pixels.error();
    if (pixels->depth() != CV_8U) return Refused("compressed image is not 8-bit");
    return GreyOfBgr(*pixels);
  }
  const Result<RawImage> raw = ReadRaw(message);
  if (!raw) return raw.error();
  return GreyOfRaw(*raw);
}

Result<Image> DecodeRosDepth(const RosMessage& message, const std::string& type,
                             double depth_unit_m) {
  if (type == kCompressed) {
    const Result<CompressedImage> image = ReadCompressed(message);
    if (!image) return image.error();
    return DepthOfCompressed(*image, depth_unit_m);
  }
  const Result<RawImage> raw = ReadRaw(message);
  if (!raw) return raw.error();
  return DepthOfRaw(*raw, depth_unit_m);
}

}  // namespace gw::importer

#include "tools/data/import/ros_messages.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "tools/data/import/image_file.h"

namespace gw::importer {
namespace {

static_assert(std::endian::native == std::endian::little, "ROS and depth pixels are little-endian");

// Reads past the end give zero and clear ok().
class RosReader {
 public:
  explicit RosReader(RosBytes bytes) : rest_(bytes) {}
  bool ok() const { return ok_; }

  template <typename T>
  T Read() {
    T value{};
    const RosBytes bytes = Take(sizeof(T));
    if (ok_) std::memcpy(&value, bytes.data(), sizeof(T));
    return value;
  }
  RosBytes Array() { return Take(Read<uint32_t>()); }
  std::string Text() {
    const RosBytes bytes = Array();
    return {bytes.begin(), bytes.end()};
  }
  Utime Stamp() {
    const auto seconds = Read<uint32_t>();
    const auto nanoseconds = Read<uint32_t>();
    return {int64_t{seconds} * 1000000 + (int64_t{nanoseconds} + 500) / 1000};
  }
  struct Header {
    Utime utime;
    std::string frame;
  };
  Header ReadHeader() {
    Read<uint32_t>();  // seq: numbered by the sender, not needed
    Header header;
    header.utime = Stamp();
    header.frame = Text();
    return header;
  }
  Eigen::Vector3d Vector() {
    const auto x = Read<double>();
    const auto y = Read<double>();
    return {x, y, Read<double>()};
  }
  // p, then q as x y z w. Fails on what is no pose.
  SE3 Pose() {
    const Eigen::Vector3d p = Vector();
    const Eigen::Vector3d xyz = Vector();
    const Eigen::Quaterniond q(Read<double>(), xyz.x(), xyz.y(), xyz.z());
    if (!(std::abs(q.norm() - 1) < 0.05) || !p.allFinite()) ok_ = false;
    return ok_ ? SE3(q, p) : SE3();
  }
  void Skip(size_t bytes) { Take(bytes); }

 private:
  RosBytes Take(size_t count) {
    if (count > rest_.size()) {
      ok_ = false;
      rest_ = {};
      return {};
    }
    const RosBytes bytes = rest_.first(count);
    rest_ = rest_.subspan(count);
    return bytes;
  }

  RosBytes rest_;
  bool ok_ = true;
};

Error Refused(const std::string& what) {
  return {ErrorCode::kBadData, what};
}

struct RawImage {
  int width = 0, height = 0;
  std::string encoding;
  size_t step = 0;
  RosBytes data;
};

Result<RawImage> ReadImage(RosBytes message) {
  RosReader reader(message);
  reader.ReadHeader();
  RawImage image;
  const auto height = reader.Read<uint32_t>();
  const auto width = reader.Read<uint32_t>();
  image.encoding = reader.Text();
  const bool big_endian = reader.Read<uint8_t>() != 0;
  image.step = reader.Read<uint32_t>();
  image.data = reader.Array();
  if (!reader.ok()) return Refused("image message is shorter than its type");
  if (width < 1 || height < 1 || width > 16384 || height > 16384) {
    return Refused("image message has an implausible size");
  }
  if (big_endian && image.encoding != "mono8")
    return Refused("big-endian images are not supported");
  image.width = static_cast<int>(width);
  image.height = static_cast<int>(height);
  return image;
}

// True when rows of this many bytes per pixel are really there.
bool Fits(const RawImage& image, size_t pixel_bytes) {
  const size_t row = static_cast<size_t>(image.width) * pixel_bytes;
  return image.step >= row &&
         image.data.size() >= image.step * (static_cast<size_t>(image.height) - 1) + row;
}

Image Allocate(const RawImage& raw, PixelFormat format) {
  Image image;
  image.width = raw.width;
  image.height = raw.height;
  image.format = format;
  image.bytes.resize(static_cast<size_t>(raw.width) * static_cast<size_t>(raw.height) *
                     static_cast<size_t>(BytesPerPixel(format)));
  return image;
}

Image CopyRows(const RawImage& raw, PixelFormat format) {
  Image image = Allocate(raw, format);
  const size_t row = image.bytes.size() / static_cast<size_t>(raw.height);
  for (size_t y = 0; y < static_cast<size_t>(raw.height); ++y) {
    std::memcpy(image.bytes.data() + y * row, raw.data.data() + y * raw.step, row);
  }
  return image;
}

Error WrongEncoding(const RawImage& raw, const char* expected) {
  return Refused("image encoding is '" + raw.encoding + "'; " + expected + " can be imported");
}

}  // namespace

Result<Utime> DecodeRosStamp(RosBytes message) {
  RosReader reader(message);
  const Utime utime = reader.ReadHeader().utime;
  if (!reader.ok()) return Refused("message is shorter than its header");
  return utime;
}

Result<Image> DecodeRosGrey(RosBytes message) {
  const Result<RawImage> raw = ReadImage(message);
  if (!raw) return raw.error();
  const bool rgb = raw->encoding == "rgb8";
  const bool color = rgb || raw->encoding == "bgr8";
  if (!color && raw->encoding != "mono8") return WrongEncoding(*raw, "mono8, rgb8 and bgr8");
  if (!Fits(*raw, color ? 3 : 1)) return Refused("image message holds fewer pixels than its size");
  if (!color) return CopyRows(*raw, PixelFormat::kGray8);
  Image image = Allocate(*raw, PixelFormat::kGray8);
  image.converted = true;
  auto out = image.bytes.begin();
  for (size_t y = 0; y < static_cast<size_t>(raw->height); ++y) {
    const uint8_t* pixel = raw->data.data() + y * raw->step;
    for (int x = 0; x < raw->width; ++x, pixel += 3) {
      *out++ = rgb ? GreyOf(pixel[0], pixel[1], pixel[2]) : GreyOf(pixel[2], pixel[1], pixel[0]);
    }
  }
  return image;
}

Result<Image> DecodeRosDepth(RosBytes message, double depth_unit_m) {
  const Result<RawImage> raw = ReadImage(message);
  if (!raw) return raw.error();
  const bool metres = raw->encoding == "32FC1";
  if (!metres && raw->encoding != "16UC1" && raw->encoding != "mono16") {
    return WrongEncoding(*raw, "16UC1, mono16 and 32FC1");
  }
  if (!Fits(*raw, metres ? 4 : 2)) return Refused("image message holds fewer pixels than its size");
  if (!metres) return CopyRows(*raw, PixelFormat::kDepth16);
  Image image = Allocate(*raw, PixelFormat::kDepth16);
  image.converted = true;
  uint8_t* out = image.bytes.data();
  for (size_t y = 0; y < static_cast<size_t>(raw->height); ++y) {
    for (size_t x = 0; x < static_cast<size_t>(raw->width); ++x, out += 2) {
      float depth_m = 0;
      std::memcpy(&depth_m, raw->data.data() + y * raw->step + 4 * x, 4);
      const double units = std::round(static_cast<double>(depth_m) / depth_unit_m);
      const bool usable = units > 0 && units <= 65535;  // false for NaN
      const uint16_t value = usable ? static_cast<uint16_t>(units) : 0;
      std::memcpy(out, &value, 2);
    }
  }
  return image;
}

Result<ImuSample> DecodeRosImu(RosBytes message) {
  constexpr size_t kCovariance = 9 * sizeof(double);
  RosReader reader(message);
  ImuSample sample;
  sample.utime = reader.ReadHeader().utime;
  reader.Skip(4 * sizeof(double) + kCovariance);  // orientation
  sample.w_I_rad_s = reader.Vector();
  reader.Skip(kCovariance);
  sample.a_I_m_s2 = reader.Vector();
  reader.Skip(kCovariance);
  sample.has_accel = true;
  if (!reader.ok()) return Refused("IMU message is shorter than its type");
  if (!sample.w_I_rad_s.allFinite() || !sample.a_I_m_s2.allFinite()) {
    return Refused("IMU message holds a number that is not finite");
  }
  return sample;
}

namespace {

std::string WithoutSlash(std::string name) {
  return name.starts_with('/') ? name.substr(1) : name;
}

}  // namespace

Result<RosPose> DecodeRosOdometry(RosBytes message) {
  RosReader reader(message);
  RosPose pose;
  pose.utime = reader.ReadHeader().utime;
  pose.child = WithoutSlash(reader.Text());
  pose.T = reader.Pose();
  if (!reader.ok()) return Refused("odometry message is too short or holds no pose");
  return pose;
}

Result<std::vector<RosTransform>> DecodeRosTransforms(RosBytes message) {
  RosReader reader(message);
  const auto count = reader.Read<uint32_t>();
  std::vector<RosTransform> transforms;
  for (uint32_t i = 0; i < count && reader.ok(); ++i) {
    const RosReader::Header header = reader.ReadHeader();
    RosTransform transform;
    transform.utime = header.utime;
    transform.parent = WithoutSlash(header.frame);
    transform.child = WithoutSlash(reader.Text());
    transform.T = reader.Pose();
    transforms.push_back(std::move(transform));
  }
  if (!reader.ok()) return Refused("transform message is too short or holds no pose");
  return transforms;
}

}  // namespace gw::importer

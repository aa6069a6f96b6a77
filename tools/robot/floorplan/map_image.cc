#include "tools/robot/floorplan/map_image.h"

#include <charconv>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <sstream>

namespace gw::floorplan {
namespace {

constexpr int kMaxWhite = 65535;
constexpr int64_t kMaxPixels = 400'000'000;  // 1 km x 1 km at 5 cm

Error NotAnImage(const std::string& path) {
  return {ErrorCode::kBadData,
          path +
              ": not an image of 8 or 16 bits with 1, 3 or 4 channels (PGM, PNG), or one that is "
              "cut off"};
}

// The header and the numbers of a PGM file (netpbm's pgm(5)): '#' starts a comment that ends with
// the line.
class PgmText {
 public:
  explicit PgmText(const std::string& bytes) : bytes_(bytes) {}

  std::optional<int> Number(int max) {
    while (at_ < bytes_.size() && (IsBlank(bytes_[at_]) || bytes_[at_] == '#')) {
      at_ = bytes_[at_] == '#' ? std::min(bytes_.find('\n', at_), bytes_.size()) : at_ + 1;
    }
    int value = 0;
    const char* const begin = bytes_.data() + at_;
    const auto [end, status] = std::from_chars(begin, bytes_.data() + bytes_.size(), value);
    if (status != std::errc() || value < 0 || value > max) return std::nullopt;
    at_ += static_cast<size_t>(end - begin);
    return value;
  }
  // What follows the one blank behind the header.
  size_t BinaryBegin() const { return at_ + 1; }
  void Skip(size_t bytes) { at_ += bytes; }

 private:
  static bool IsBlank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

  const std::string& bytes_;
  size_t at_ = 0;
};

uint8_t Scaled(int value, int white) {
  return static_cast<uint8_t>((std::min(value, white) * 255 + white / 2) / white);
}

std::optional<MapImage> ReadPgm(const std::string& bytes) {
  const bool binary = bytes[1] == '5';
  PgmText text(bytes);
  text.Skip(2);
  const auto width = text.Number(1 << 20);
  const auto height = text.Number(1 << 20);
  const auto white = text.Number(kMaxWhite);
  if (!width || !height || !white || *white == 0) return std::nullopt;
  const int64_t pixels = static_cast<int64_t>(*width) * *height;
  const size_t bytes_each = *white > 255 ? 2 : 1;
  // The smallest file that can hold them: a digit and a blank for each, or its bytes.
  const size_t least = binary ? text.BinaryBegin() + pixels * bytes_each : 2 * pixels - 1;
  if (pixels == 0 || pixels > kMaxPixels || bytes.size() < least) return std::nullopt;
  MapImage image{*width, *height, std::vector<uint8_t>(pixels), {}};
  const auto* const data = reinterpret_cast<const uint8_t*>(bytes.data()) + text.BinaryBegin();
  for (int64_t i = 0; i < pixels; ++i) {
    int value = 0;
    if (binary) {
      value = bytes_each == 1 ? data[i] : data[2 * i] << 8 | data[2 * i + 1];
    } else {
      const auto number = text.Number(kMaxWhite);
      if (!number) return std::nullopt;
      value = *number;
    }
    image.grey[i] = Scaled(value, *white);
  }
  return image;
}

// 8 or 16 bits, 1, 3 or 4 channels of which the fourth is alpha.
template <typename Value>
MapImage Averaged(const cv::Mat& in) {
  constexpr int kWhite = std::numeric_limits<Value>::max();
  const int colours = in.channels() == 1 ? 1 : 3;
  const bool alpha = in.channels() == 4;
  MapImage image{in.cols, in.rows, std::vector<uint8_t>(in.total()), {}};
  if (alpha) image.opaque.resize(in.total());
  size_t i = 0;
  for (int y = 0; y < in.rows; ++y) {
    const Value* pixel = in.ptr<Value>(y);
    for (int x = 0; x < in.cols; ++x, ++i, pixel += in.channels()) {
      int sum = 0;
      for (int c = 0; c < colours; ++c) sum += pixel[c];
      image.grey[i] = Scaled(sum / colours, kWhite);
      if (alpha) image.opaque[i] = pixel[3] == kWhite ? 1 : 0;
    }
  }
  return image;
}

Result<MapImage> ReadWithOpenCv(const std::string& path) {
  cv::Mat image;
  try {
    image = cv::imread(path, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    image.release();  // larger than OpenCV takes
  }
  const bool channels = image.channels() == 1 || image.channels() == 3 || image.channels() == 4;
  if (image.empty() || !channels) return NotAnImage(path);
  if (image.depth() == CV_8U) return Averaged<uint8_t>(image);
  if (image.depth() == CV_16U) return Averaged<uint16_t>(image);
  return NotAnImage(path);
}

}  // namespace

Result<MapImage> LoadMapImage(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    return Error{ErrorCode::kNotFound, path +
                                           ": cannot open the image of the map; `image` in the "
                                           "map's YAML is absolute, or relative to the YAML's "
                                           "folder"};
  }
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  const std::string bytes = text.str();
  if (!bytes.starts_with("P2") && !bytes.starts_with("P5")) return ReadWithOpenCv(path);
  std::optional<MapImage> image = ReadPgm(bytes);
  if (!image) return NotAnImage(path);
  return *std::move(image);
}

}  // namespace gw::floorplan

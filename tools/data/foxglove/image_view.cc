#include "tools/data/foxglove/image_view.h"

#include <algorithm>
#include <array>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tools/data/files/json.h"

namespace gw::foxglove {
namespace {

constexpr int kJpegQuality = 70;  // of 100; features stay recognisable, 20 kB
constexpr const char* kCameraFrame = "camera";

struct FateStyle {
  FeatureFate fate;
  Color color;
  double size_px;
};
constexpr std::array<FateStyle, 4> kFates{{{FeatureFate::kUnmatched, {0.62, 0.65, 0.70, 0.55}, 2},
                                           {FeatureFate::kInlier, {0.20, 0.83, 0.45, 1}, 4},
                                           {FeatureFate::kOutlier, {0.95, 0.26, 0.21, 1}, 4},
                                           {FeatureFate::kNew, {0.25, 0.65, 1.0, 1}, 4}}};

// foxglove.PointsAnnotation, one point each.
Json Points(Utime utime, const FateStyle& style, Json points) {
  return {{"timestamp", JsonTime(utime)},    {"type", 1},
          {"points", std::move(points)},     {"outline_color", JsonColor(style.color)},
          {"outline_colors", Json::array()}, {"fill_color", JsonColor({0, 0, 0, 0})},
          {"thickness", style.size_px},      {"metadata", Json::array()}};
}

}  // namespace

double ImageScale(int width) {
  return width > kMaxImageWidth ? static_cast<double>(kMaxImageWidth) / width : 1.0;
}

std::optional<Json> ImageMessage(Utime utime, const ImageView& image) {
  if (image.empty() || image.format != PixelFormat::kGray8) return std::nullopt;
  const cv::Mat pixels(image.height, image.width, CV_8UC1, const_cast<uint8_t*>(image.data),
                       static_cast<size_t>(image.stride));
  cv::Mat small = pixels;
  const double scale = ImageScale(image.width);
  if (scale < 1) cv::resize(pixels, small, cv::Size(), scale, scale, cv::INTER_AREA);
  std::vector<uint8_t> jpeg;
  try {
    if (!cv::imencode(".jpg", small, jpeg, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality})) {
      return std::nullopt;
    }
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  return Json{{"timestamp", JsonTime(utime)},
              {"frame_id", kCameraFrame},
              {"data", Base64(jpeg)},
              {"format", "jpeg"}};
}

Json FeaturesMessage(const FrameDetail& detail, double scale,
                     const std::optional<CameraGeometry>& geometry) {
  std::array<Json, kFates.size()> points;
  points.fill(Json::array());
  for (const FrameDetail::Feature& f : detail.features) {
    Eigen::Vector2d uv(f.u, f.v);
    if (geometry) {
      uv = RectifiedToSource(geometry->rectified, geometry->calibration.camera.left,
                             geometry->rectification.R_C0Rect, uv);
    }
    // (0, 0) is the centre of a pixel, before and after.
    const Eigen::Vector2d small = (uv.array() + 0.5) * scale - 0.5;
    const auto tenth = [](double v) { return std::round(v * 10) / 10; };
    points[static_cast<size_t>(f.fate)].push_back(
        {{"x", tenth(small.x())}, {"y", tenth(small.y())}});
  }
  Json groups = Json::array();
  for (const FateStyle& style : kFates) {
    Json& group = points[static_cast<size_t>(style.fate)];
    groups.push_back(Points(detail.utime, style, std::move(group)));
  }
  return {{"timestamp", JsonTime(detail.utime)},
          {"circles", Json::array()},
          {"points", std::move(groups)},
          {"texts", Json::array()},
          {"metadata", Json::array()}};
}

Json CalibrationMessage(Utime utime, const RectifiedCamera& camera) {
  const double scale = ImageScale(camera.width);
  const double fx = camera.fx * scale, fy = camera.fy * scale;
  const double cx = (camera.cx + 0.5) * scale - 0.5, cy = (camera.cy + 0.5) * scale - 0.5;
  return {{"timestamp", JsonTime(utime)},
          {"frame_id", kCameraFrame},
          {"width", std::lround(camera.width * scale)},
          {"height", std::lround(camera.height * scale)},
          {"distortion_model", ""},
          {"D", Json::array()},
          {"K", {fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0}},
          {"R", {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}},
          {"P", {fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0}}};
}

}  // namespace gw::foxglove

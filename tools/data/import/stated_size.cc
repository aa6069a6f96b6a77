#include "tools/data/import/stated_size.h"

#include <cmath>

namespace gw::importer {

Result<Done> FitStatedSize(double stated_width, double stated_height, const std::string& where,
                           const CameraCalibration& camera, PinholeIntrinsics* eye,
                           std::vector<std::string>& warnings) {
  if (stated_width == camera.width && stated_height == camera.height) return Done{};
  const auto size = [](double width, double height) {
    return std::to_string(std::lround(width)) + " x " + std::to_string(std::lround(height));
  };
  const std::string both = where + ": the intrinsics are stated for " +
                           size(stated_width, stated_height) + ", the images are " +
                           size(camera.width, camera.height);
  const double scale = camera.width / stated_width;
  // A resized height is a whole number: rounded by at most half a row.
  if (!(stated_width > 0) || std::abs(stated_height * scale - camera.height) > 0.5) {
    return Error{ErrorCode::kBadData,
                 both + ", which is another shape; give the intrinsics of the images"};
  }
  eye->fx *= scale;
  eye->fy *= scale;
  // Pixel (0, 0) is the centre of the first pixel, half a pixel from the corner that stays.
  eye->cx = (eye->cx + 0.5) * scale - 0.5;
  eye->cy = (eye->cy + 0.5) * scale - 0.5;
  warnings.push_back(both + "; taken as the same images resized, the intrinsics are scaled");
  return Done{};
}

}  // namespace gw::importer

// A camera image as viewers get it: made smaller, compressed; and the features on it.
#pragma once

#include <optional>

#include "common/camera/camera_model.h"
#include "common/contract/frame_detail.h"
#include "common/core/image_view.h"
#include "tools/data/foxglove/json_parts.h"

namespace gw::foxglove {

inline constexpr int kMaxImageWidth = 480;  // px; wider images are made smaller

// How much smaller: image width to sent width.
double ImageScale(int width);

// foxglove.CompressedImage (JPEG). Empty when the image cannot be compressed.
std::optional<Json> ImageMessage(Utime utime, const ImageView& image);

// foxglove.ImageAnnotations for the image of ImageMessage, scaled as it. geometry: where features
// are of a rectified image and the camera's is not; absent: the same.
Json FeaturesMessage(const FrameDetail& detail, double scale,
                     const std::optional<CameraGeometry>& geometry);

// foxglove.CameraCalibration of the rectified camera, scaled as the image.
Json CalibrationMessage(Utime utime, const RectifiedCamera& camera);

}  // namespace gw::foxglove

// Depth of a feature from a depth image that is registered to the grey image pixel by pixel.
#pragma once

#include "common/camera/camera_model.h"
#include "common/core/image_view.h"

namespace gw::frontend {

class DepthLookup {
 public:
  explicit DepthLookup(const CameraGeometry& geometry);

  // Depth (m) of the surface at pixel (u, v) of the grey image, from the 3x3 pixels around it; -1
  // where there is none: too few measured pixels, below depth_min_m, or the 3x3 pixels lie on an
  // edge without a clear front side.
  // A corner at a depth edge belongs to the surface in front (the one behind only ends there by
  // occlusion), so the nearer pixels win if there are enough of them. Mean of the inverse
  // depths, which is what such a sensor measures.
  // Precondition: `depth` is kDepth16.
  float At(const ImageView& depth, float u, float v) const;

  // Two depths, m, so many pixels apart, that neither a plane nor the noise of the sensor makes.
  bool IsEdge(double near, double far, double pixels) const;

 private:
  double unit_m_, min_m_;
  double noise_per_m_;  // standard deviation of a depth z: noise_per_m_ * z^2
};

}  // namespace gw::frontend

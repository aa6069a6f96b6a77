// The infra-red dot pattern of a D4xx projector, drawn into a rendered image. The projector sits
// beside the left eye, so dots move with the depth of what they fall on; their light falls off with
// the square of the distance and is reflected as the surface reflects the rest.
#pragma once

#include <cstdint>
#include <vector>

namespace gw::camera {

struct DotProjector {
  double fx = 385, cx = 320;    // intrinsics of the camera, px
  double offset_m = 0.03;       // how far right of the eye the projector sits
  double pitch_px = 9;          // mean distance of dots: about 5000 dots in the field of view
  double sigma_px = 0.9;        // size of a dot in the image
  double radiance_at_1m = 1.2;  // radiance at the middle of a dot on a white surface, at 150 mW
};

// Draws the dots into `radiance` and `inverse_depth` (1/m, 0 for nothing), which hold the image row
// by row as the simulator renders it. `seed` is that of the pattern, which is fixed for one
// projector.
void ProjectDots(const DotProjector& projector, uint64_t seed, int width, int height,
                 const std::vector<float>& inverse_depth, std::vector<float>* radiance);

}  // namespace gw::camera

// The infra-red dot pattern of a D4xx projector, drawn into a rendered image. The projector sits
// beside the left eye, so dots move with the depth of what they fall on; their light falls off with
// the square of the distance and is reflected as the surface reflects the rest.
#pragma once

#include <cstdint>
#include <vector>

namespace gw::camera {

struct DotProjector {
  double fx = 385, cx = 320;    // of the camera, px
  double offset_m = 0.03;       // of the projector from the eye, to the right
  double pitch_px = 9;          // mean distance of dots; about 5000 dots in the field of view
  double sigma_px = 0.9;        // size of a dot in the image
  double radiance_at_1m = 1.2;  // of a dot on a white surface, at its middle; at 150 mW
};

// radiance and inverse_depth (1/m, 0: nothing) row by row, as the simulator renders them. seed: of
// the pattern, which is fixed for one projector.
void ProjectDots(const DotProjector& projector, uint64_t seed, int width, int height,
                 const std::vector<float>& inverse_depth, std::vector<float>* radiance);

}  // namespace gw::camera

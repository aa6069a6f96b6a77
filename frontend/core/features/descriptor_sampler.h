// Orientation and descriptor of a patch of one pyramid level.
#pragma once

#include <cstdint>
#include <vector>

#include "common/contract/map.h"
#include "frontend/core/features/image_buffer.h"
#include "frontend/core/features/orb_pattern.h"

namespace gw::frontend {

// Direction from the centre to the intensity centroid of the disc of kOrbPatchRadius (Rosin 1999),
// rad in (-pi, pi]; 0 for a patch without a direction.
// Precondition: (x, y) is at least kOrbPatchRadius + 1 px from every border of the image.
float IntensityCentroidAngle(const ImageBuffer& image, int x, int y);

class DescriptorSampler {
 public:
  // `stride`: of the images that will be sampled.
  DescriptorSampler(const OrbPattern& pattern, int stride);

  // Descriptor of the patch around (x, y) turned by `angle`. Same precondition as above.
  Descriptor Sample(const ImageBuffer& smooth, int x, int y, float angle) const;

 private:
  // The pattern is turned in steps of 5.6 degrees: at most 0.7 px off at the rim of the disc.
  static constexpr int kNumAngles = 64;

  int stride_;
  // [angle][test]: offsets of pixel a (lower half) and b from the patch's top left corner. One load
  // for two: the loads are what sampling waits for.
  std::vector<uint64_t> offsets_;
};

}  // namespace gw::frontend

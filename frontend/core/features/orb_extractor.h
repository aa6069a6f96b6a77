// ORB-type features of one grey image: oriented FAST corners on an image pyramid, spread over the
// image, with a rotated binary descriptor.
#pragma once

#include <vector>

#include "common/config/frontend_config.h"
#include "common/contract/map.h"
#include "common/core/image_view.h"
#include "common/core/result.h"
#include "frontend/core/features/descriptor_sampler.h"
#include "frontend/core/features/image_pyramid.h"
#include "frontend/core/features/orb_detector.h"
#include "frontend/core/features/orb_keypoint.h"
#include "frontend/core/features/orb_spread.h"

namespace gw::frontend {

class OrbExtractor {
 public:
  // Error kBadConfig: the thresholds are in the wrong order, or the image is too small for a patch.
  static Result<OrbExtractor> Create(const OrbConfig& config, int width, int height);

  // Margin of every level that stays without features: patch and sub-pixel steps must fit in.
  static constexpr int kBorder = kOrbPatchRadius + 1;

  // At most config.num_features keypoints, by level; descriptors one per keypoint. Replaces the
  // content of both. `valid` (may be null): per pixel of the image the distance in px, up to 255,
  // to the next pixel without content; patches that would reach such pixels are left out.
  // Precondition: `image` is kGray8 of the size given to Create().
  void Extract(const ImageView& image, const ImageBuffer* valid,
               std::vector<OrbKeypoint>* keypoints, std::vector<Descriptor>* descriptors);

  // The pyramid of the image that Extract() saw last.
  const ImagePyramid& pyramid() const { return pyramid_; }

 private:
  OrbExtractor(const OrbConfig& config, int width, int height);

  OrbConfig config_;
  ImagePyramid pyramid_;
  OrbDetector detector_;
  OrbSpread spread_;
  DescriptorSampler sampler_;
  std::vector<std::vector<Corner>> corners_;  // per level
  std::vector<Corner> selected_;
};

}  // namespace gw::frontend

// From one camera message to the features that tracking and mapping use.
#pragma once

#include <memory>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/config/frontend_config.h"
#include "common/contract/map.h"
#include "common/contract/samples.h"
#include "common/core/result.h"

namespace gw::frontend {

// Features of one camera message, in the rectified (undistorted) left image.
//
// u, v: px, pixel centres are integers; undistorted features of an RGB-D image may lie a little
// outside [0, width) x [0, height). angle: from +u towards +v, in (-pi, pi]. A feature with depth
// (depth > 0, inside the camera's depth range) has u_right = u - bf / depth, which near the left
// edge of an RGB-D image may be negative. One that is somewhat beyond the range has u_right alone:
// ask has_depth() and has_disparity().
struct FeatureFrame {
  // How far the partner of a feature lies below its row in the right image, px: noise, where the
  // eyes are rectified and of one instant (eye_sync.h).
  struct RowOffset {
    int feature = 0;
    float dv = 0;
  };

  std::vector<Feature> features;        // by level, finest first
  std::vector<Descriptor> descriptors;  // one per feature
  int num_detected = 0;                 // N_det: features found, at most OrbConfig::num_features
  std::vector<RowOffset> row_offsets;   // of some of the features; stereo only
  double brightness = 0;                // mean of the left image as it came, grey levels
};

// Deterministic: the same frames give the same features, byte for byte. Keeps buffers between
// frames, but no state that changes the result.
class FeatureExtractor {
 public:
  // Error kBadConfig: the values do not fit together; names the field.
  static Result<FeatureExtractor> Create(const OrbConfig& config, const CameraGeometry& geometry);

  ~FeatureExtractor();
  FeatureExtractor(FeatureExtractor&&) noexcept;
  FeatureExtractor& operator=(FeatureExtractor&&) noexcept;

  enum class Outcome {
    kOk,
    kBadImage,       // left image missing, wrong size or format: no features
    kMissingDepth,   // right or depth image missing, wrong size or format: features without depth
    kOneEyeTwice,    // left and right image seem to be the same: features, few with depth
    kEyesExchanged,  // left seems to be right: the same
  };
  // Replaces the content of `out`.
  Outcome Extract(const CameraFrame& frame, FeatureFrame* out);

 private:
  class Impl;
  explicit FeatureExtractor(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace gw::frontend

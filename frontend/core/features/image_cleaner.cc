#include "frontend/core/features/image_cleaner.h"

#include "frontend/core/features/rolling_shutter.h"

namespace gw::frontend {
namespace {

// Depth and grey image of the two nearest moments are no farther apart.
constexpr double kHalfAnImage = 0.5;

}  // namespace

const FeatureFrame* ImageCleaner::LeaveOutFixed(Utime utime, const FeatureFrame& seen,
                                                const std::optional<CameraStep>& step) {
  fixed_.Observe(utime, seen, step);
  if (!fixed_.any()) return &seen;
  of_world_ = fixed_.Without(seen);
  return &of_world_;
}

void ImageCleaner::JudgeEyes(const FeatureFrame& seen, const SE3& T_ab, DurationUs dt) {
  depth_spoilt_ = false;
  if (seen.row_offsets.empty()) return;
  eyes_.Observe(seen, T_ab, dt);
  depth_spoilt_ = eyes_.SpoilsDepth(seen, T_ab, dt);
}

ViewFault ImageCleaner::depth_fault() const {
  if (depth_sync_.IsLate(kHalfAnImage)) return ViewFault::kDepthLate;
  return depth_sync_.IsEarly(kHalfAnImage) ? ViewFault::kDepthEarly : ViewFault::kNone;
}

const FeatureFrame* ImageCleaner::Correct(const FeatureFrame* of_world, const SE3& T_ab,
                                          DurationUs dt) {
  const double late = depth_sync_.Lateness();
  if (camera_.readout_s <= 0 && !depth_spoilt_ && late == 0) return of_world;
  corrected_ = *of_world;
  if (late != 0) depth_sync_.Correct(late, T_ab, &corrected_.features);
  if (camera_.readout_s > 0) {
    UndoRollingShutter(camera_, camera_.readout_s, T_ab.Log().tail<3>() / dt.seconds(),
                       &corrected_.features);
  }
  if (depth_spoilt_) {
    for (Feature& f : corrected_.features) f.depth = f.u_right = -1;
  }
  return &corrected_;
}

}  // namespace gw::frontend

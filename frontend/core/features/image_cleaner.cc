#include "frontend/core/features/image_cleaner.h"

#include "frontend/core/features/rolling_shutter.h"

namespace gw::frontend {

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

const FeatureFrame* ImageCleaner::Correct(const FeatureFrame* of_world, const SE3& T_ab,
                                          DurationUs dt) {
  if (camera_.readout_s <= 0 && !depth_spoilt_) return of_world;
  corrected_ = *of_world;
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

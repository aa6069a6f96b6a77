#include "frontend/core/place/piece_start.h"

#include "frontend/core/place/rich_image.h"
#include "frontend/core/place/view_change.h"

namespace gw::frontend {

bool PieceStart::Observe(Utime utime, bool place_known, const FeatureFrame& frame,
                         const std::optional<SE3>& T_OC) {
  if (place_known || !T_OC) {
    since_.reset();
    compared_.reset();
    return false;
  }
  if (!since_) since_ = utime;
  if (frame.num_detected < kRichImage) return false;
  if (!compared_) {
    compared_ = Image{frame, *T_OC};
    return false;
  }
  const SE3 motion = compared_->T_OC.inverse() * *T_OC;
  if (motion.translation().norm() < kWay && LogSO3(motion.rotation()).norm() < kTurn) return false;
  const bool agrees = Agrees(frame, *T_OC);
  compared_ = Image{frame, *T_OC};
  return agrees && utime - *since_ >= kPatience;
}

// What moves with the camera is seen where it was.
bool PieceStart::Agrees(const FeatureFrame& frame, const SE3& T_OC) const {
  const double moved =
      CountSeenAgain(camera_, compared_->frame, frame, T_OC.inverse() * compared_->T_OC).share();
  const double fixed = CountSeenAgain(camera_, compared_->frame, frame, SE3()).share();
  return moved >= kLeastSeen && moved > fixed;
}

}  // namespace gw::frontend

#include "frontend/core/place/piece_start.h"

namespace gw::frontend {

bool PieceStart::Observe(Utime utime, bool place_known, const std::optional<SE3>& T_OC) {
  if (place_known || !T_OC) {
    since_.reset();
    return false;
  }
  if (!since_) since_ = Begin{utime, *T_OC};
  const SE3 motion = since_->T_OC.inverse() * *T_OC;
  const bool moved =
      motion.translation().norm() >= kWay || LogSO3(motion.rotation()).norm() >= kTurn;
  return moved && utime - since_->utime >= kPatience;
}

}  // namespace gw::frontend

#include "frontend/core/map/keyframe_doubt.h"

#include "common/good_weights/camera_motion.h"

namespace gw::frontend {

Matrix6d KeyframeDoubt::At(KeyframeId id, const SE3& T_KC) const {
  const auto found = doubts_.find(id);
  return found == doubts_.end() ? Matrix6d::Zero() : InCamera(found->second, T_KC);
}

void KeyframeDoubt::Set(KeyframeId id, const Matrix6d& cov_T_WK) {
  if (cov_T_WK.isZero(0)) return;
  doubts_[id] = cov_T_WK;
}

}  // namespace gw::frontend

#include "frontend/core/map/keyframe_doubt.h"

namespace gw::frontend {

Matrix6d KeyframeDoubt::At(KeyframeId id, const SE3& T_KC) const {
  const auto found = doubts_.find(id);
  if (found == doubts_.end()) return Matrix6d::Zero();
  const Matrix6d A = T_KC.inverse().Adjoint();
  return A * found->second * A.transpose();
}

void KeyframeDoubt::Set(KeyframeId id, const Matrix6d& cov_T_WK) {
  if (cov_T_WK.isZero(0)) return;
  doubts_[id] = cov_T_WK;
}

}  // namespace gw::frontend

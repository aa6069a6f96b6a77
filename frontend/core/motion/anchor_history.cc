#include "frontend/core/motion/anchor_history.h"

#include <algorithm>

namespace gw::frontend {

std::optional<AnchorHistory::Since> AnchorHistory::From(Utime then) const {
  const auto found = std::find_if(anchors_.begin(), anchors_.end(),
                                  [then](const Anchor& a) { return a.utime >= then; });
  if (found == anchors_.end()) return std::nullopt;
  return Since{found->utime, found->T_WO, found->cov_T_WC,
               static_cast<int>(anchors_.end() - found) - 1};
}

void AnchorHistory::Remember(Utime utime, const SE3& T_WO, const Matrix6d& cov_T_WC) {
  anchors_.push_back({utime, T_WO, cov_T_WC});
  while (utime - anchors_.front().utime > kSpan) anchors_.pop_front();
}

void AnchorHistory::Move(const SE3& T_correction) {
  for (Anchor& a : anchors_) a.T_WO = T_correction * a.T_WO;
}

}  // namespace gw::frontend

#include "frontend/core/motion/anchor_history.h"

#include <algorithm>
#include <iterator>

namespace gw::frontend {

AnchorHistory::Place AnchorHistory::FirstFrom(Utime then) const {
  return std::find_if(anchors_.begin(), anchors_.end(),
                      [then](const Anchor& a) { return a.utime >= then; });
}

std::optional<AnchorHistory::Since> AnchorHistory::At(const Place& place) const {
  if (place == anchors_.end()) return std::nullopt;
  return Since{place->utime, place->T_WO, place->cov_T_WC,
               static_cast<int>(anchors_.end() - place) - 1};
}

std::optional<AnchorHistory::Since> AnchorHistory::From(Utime then) const {
  return At(FirstFrom(then));
}

std::optional<AnchorHistory::Since> AnchorHistory::Before(Utime then) const {
  const Place first = FirstFrom(then);
  const bool older = first != anchors_.end() && first != anchors_.begin();
  return At(older ? std::prev(first) : first);
}

void AnchorHistory::Remember(Utime utime, const SE3& T_WO, const Matrix6d& cov_T_WC) {
  anchors_.push_back({utime, T_WO, cov_T_WC});
  while (utime - anchors_.front().utime > kSpan) anchors_.pop_front();
}

void AnchorHistory::Move(const SE3& T_correction) {
  for (Anchor& a : anchors_) a.T_WO = T_correction * a.T_WO;
}

}  // namespace gw::frontend

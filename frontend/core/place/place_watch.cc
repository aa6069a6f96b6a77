#include "frontend/core/place/place_watch.h"

namespace gw::frontend {

void PlaceWatch::CompareViews(const FeatureFrame& frame, const std::optional<SE3>& T_OC,
                              bool weak) {
  newest_ = weak ? view_.Compare(frame, T_OC) : ViewVerdict::kUnknown;
  view_.Remember(frame, T_OC);
}

bool PlaceWatch::Contradicts(PlaceEvidence evidence) const {
  evidence.view = newest_;
  return place_.Contradicts(evidence);
}

PlaceWatch::Verdict PlaceWatch::Observe(PlaceEvidence evidence, const FeatureFrame& frame,
                                        bool known) {
  evidence.view = newest_;
  Verdict verdict;
  verdict.ask = place_.Observe(evidence);
  verdict.sure = known && !place_.in_doubt();
  const bool lost = !verdict.sure && evidence.map_there;
  verdict.map_on = piece_start_.Observe(evidence.utime, !lost, frame, evidence.T_OC);
  // Nobody carried it: it goes on where dead reckoning says, in the map as it is.
  if (verdict.map_on && known && place_.followed()) {
    place_.EndDoubt();
    verdict.map_on = false;
    verdict.sure = true;
  }
  return verdict;
}

void PlaceWatch::Answer(const PlaceMatch& match, const SE3& T_OC, KeyframeId piece) {
  if (const auto confirmed = place_.Take(match, T_OC)) {
    confirmed_ = Confirmed{confirmed->T_WO, confirmed->cov_T_WC, piece};
  }
}

void PlaceWatch::BeginPiece() {
  place_ = PlaceConfirmation(doubts_);
  piece_start_ = PieceStart(camera_);
}

void PlaceWatch::Restart() {
  place_ = PlaceConfirmation(doubts_);
  confirmed_.reset();
  view_ = ViewChange(camera_);
}

}  // namespace gw::frontend

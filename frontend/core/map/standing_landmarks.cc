#include "frontend/core/map/standing_landmarks.h"

#include <algorithm>
#include <cmath>

#include "common/core/log_odds.h"

namespace gw::frontend {
namespace {

const double kFor = std::log(0.7 / 0.1), kAgainst = std::log(0.3 / 0.9);

}  // namespace

void StandingLandmarks::Forget(Utime now) {
  std::vector<int64_t> unwanted;
  known_.ForEach([&](int64_t id, const Known& known) {
    if (known.seen > now || now - known.seen > kMemory) unwanted.push_back(id);
  });
  for (const int64_t id : unwanted) known_.Erase(id);
}

void StandingLandmarks::Observe(Utime utime, bool agreed, const std::vector<LandmarkId>& inliers) {
  if (utime < cleaned_ || utime - cleaned_ > kMemory) {
    Forget(utime);
    cleaned_ = utime;
  }
  for (const LandmarkId id : inliers) {
    if (!id.valid()) continue;
    const auto [known, is_new] = known_.Insert(id.value);
    if (is_new) known->since = utime;
    known->seen = utime;
    known->evidence = std::clamp(known->evidence + (agreed ? kFor : kAgainst), -kDecisiveLogOdds,
                                 kDecisiveLogOdds);
    known->proven =
        known->proven || (known->evidence >= kDecisiveLogOdds && utime - known->since >= kProof);
    knows_any_ = knows_any_ || known->proven;
  }
}

void StandingLandmarks::Merge(const std::vector<LandmarkMerge>& merges) {
  for (const LandmarkMerge& m : merges) {
    const Known* const from = known_.Find(m.from.value);
    if (from == nullptr) continue;
    const Known known = *from;
    known_.Erase(m.from.value);
    const auto [into, is_new] = known_.Insert(m.into.value);
    if (is_new || known.proven) *into = known;
  }
}

int StandingLandmarks::Count(const std::vector<LandmarkId>& ids) const {
  return static_cast<int>(std::count_if(ids.begin(), ids.end(),
                                        [this](LandmarkId id) { return id.valid() && Knows(id); }));
}

}  // namespace gw::frontend

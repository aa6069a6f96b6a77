#include "frontend/core/map/standing_landmarks.h"

#include <algorithm>

namespace gw::frontend {

template <typename Wanted>
void StandingLandmarks::Forget(const Wanted& wanted) {
  std::vector<int64_t> unwanted;
  known_.ForEach([&](int64_t id, const Known& known) {
    if (!wanted(known)) unwanted.push_back(id);
  });
  for (const int64_t id : unwanted) known_.Erase(id);
}

void StandingLandmarks::Observe(Utime utime, bool agreed, const std::vector<LandmarkId>& inliers) {
  // A contradiction puts in doubt what is not proven yet.
  if (!agreed) Forget([](const Known& known) { return known.proven; });
  if (utime < cleaned_ || utime - cleaned_ > kMemory) {
    Forget([&](const Known& known) { return known.seen <= utime && utime - known.seen < kMemory; });
    cleaned_ = utime;
  }
  for (const LandmarkId id : inliers) {
    if (!id.valid()) continue;
    Known* known = known_.Find(id.value);
    if (known == nullptr) {
      if (!agreed) continue;
      known = known_.Insert(id.value).first;
      known->since = utime;
    }
    known->seen = utime;
    known->proven = known->proven || utime - known->since >= kProof;
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

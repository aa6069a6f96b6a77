#include "frontend/core/features/row_index.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace gw::frontend {
namespace {

constexpr int kUnmistakable = 50;  // of 256 bits

}  // namespace

// Counting sort by row.
void RowIndex::Fill(const std::vector<OrbKeypoint>& keypoints) {
  row_begin_.assign(static_cast<size_t>(height_) + 1, 0);
  const auto row_of = [this](const OrbKeypoint& k) {
    return static_cast<size_t>(std::clamp(static_cast<int>(std::lround(k.v)), 0, height_ - 1));
  };
  for (const OrbKeypoint& k : keypoints) ++row_begin_[row_of(k) + 1];
  for (size_t y = 0; y < static_cast<size_t>(height_); ++y) row_begin_[y + 1] += row_begin_[y];
  by_row_.resize(keypoints.size());
  for (size_t j = keypoints.size(); j-- > 0;) {
    // Filled from the back; afterwards row_begin_[y + 1] is the begin of row y.
    const OrbKeypoint& k = keypoints[j];
    by_row_[static_cast<size_t>(--row_begin_[row_of(k) + 1])] = {k.u, k.v, k.level,
                                                                 static_cast<int>(j)};
  }
  row_begin_.erase(row_begin_.begin());
  row_begin_.push_back(static_cast<int>(keypoints.size()));
}

std::span<const RowIndex::Entry> RowIndex::Near(float v, float reach) const {
  const int first = std::clamp(static_cast<int>(std::floor(v - reach)), 0, height_ - 1);
  const int last = std::clamp(static_cast<int>(std::ceil(v + reach)), 0, height_ - 1);
  return {by_row_.data() + row_begin_[static_cast<size_t>(first)],
          by_row_.data() + row_begin_[static_cast<size_t>(last) + 1]};
}

int UnmistakablePartner(const StereoSide& left, size_t i, const StereoSide& right,
                        const RowIndex& right_rows, const PartnerWindow& window) {
  const OrbKeypoint& k = left.keypoints[i];
  int best = -1;
  int distance = kUnmistakable + 1;
  int second = 257;  // more than there can be
  for (const RowIndex::Entry& r : right_rows.Near(k.v, window.rows)) {
    if (std::abs(r.level - k.level) > kMaxLevelStep || std::abs(r.v - k.v) > window.rows) continue;
    const float disparity = k.u - r.u;
    if (disparity < window.least_disparity || disparity > window.most_disparity) continue;
    const int d =
        HammingDistance(left.descriptors[i], right.descriptors[static_cast<size_t>(r.index)]);
    if (d < distance) {
      second = best < 0 ? second : distance;
      distance = d;
      best = r.index;
    } else if (d < second) {
      second = d;
    }
  }
  // The same corner found at another level of the pyramid is no rival, but rarely is as similar.
  return best < 0 || distance * 5 > second * 4 ? -1 : best;
}

}  // namespace gw::frontend

#include "common/vision/feature_grid.h"

#include <algorithm>

namespace gw {

FeatureGrid::FeatureGrid(const std::vector<Feature>& features) {
  if (features.empty()) return;
  u0_ = features[0].u;
  v0_ = features[0].v;
  float u1 = u0_;
  float v1 = v0_;
  for (const Feature& f : features) {
    u0_ = std::min(u0_, f.u);
    v0_ = std::min(v0_, f.v);
    u1 = std::max(u1, f.u);
    v1 = std::max(v1, f.v);
  }
  columns_ = static_cast<int>((u1 - u0_) / kCell) + 1;
  rows_ = static_cast<int>((v1 - v0_) / kCell) + 1;
  const auto cell = [this](const Feature& f) {
    return static_cast<size_t>(Cell(f.v - v0_, rows_)) * columns_ + Cell(f.u - u0_, columns_);
  };
  // Counting sort.
  start_.assign(static_cast<size_t>(columns_) * rows_ + 1, 0);
  for (const Feature& f : features) ++start_[cell(f) + 1];
  for (size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
  entries_.resize(features.size());
  std::vector<int32_t> next(start_.begin(), start_.end() - 1);
  for (size_t i = 0; i < features.size(); ++i) {
    entries_[next[cell(features[i])]++] = {features[i].u, features[i].v, static_cast<int>(i)};
  }
}

}  // namespace gw

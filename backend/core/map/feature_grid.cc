#include "backend/core/map/feature_grid.h"

#include <algorithm>
#include <cmath>

namespace gw::backend {

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
  const auto cell = [&](const Feature& f) {
    const int row = static_cast<int>((f.v - v0_) / kCell);
    const int column = static_cast<int>((f.u - u0_) / kCell);
    return static_cast<size_t>(row) * columns_ + column;
  };
  start_.assign(static_cast<size_t>(columns_) * rows_ + 1, 0);
  for (const Feature& f : features) ++start_[cell(f) + 1];
  for (size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
  items_.resize(features.size());
  std::vector<int32_t> next(start_.begin(), start_.end() - 1);
  for (size_t i = 0; i < features.size(); ++i) {
    items_[next[cell(features[i])]++] = static_cast<int32_t>(i);
  }
}

void FeatureGrid::Near(double u, double v, double radius, std::vector<int>& out) const {
  if (columns_ == 0 || !std::isfinite(u) || !std::isfinite(v)) return;
  const auto clamp_cell = [](double x, int n) {
    return static_cast<int>(std::clamp(std::floor(x / kCell), -1.0, static_cast<double>(n)));
  };
  const int c0 = std::max(0, clamp_cell(u - radius - u0_, columns_));
  const int c1 = std::min(columns_ - 1, clamp_cell(u + radius - u0_, columns_));
  const int r0 = std::max(0, clamp_cell(v - radius - v0_, rows_));
  const int r1 = std::min(rows_ - 1, clamp_cell(v + radius - v0_, rows_));
  for (int r = r0; r <= r1; ++r) {
    if (c0 > c1) return;
    const size_t row = static_cast<size_t>(r) * columns_;
    out.insert(out.end(), items_.begin() + start_[row + c0], items_.begin() + start_[row + c1 + 1]);
  }
}

}  // namespace gw::backend

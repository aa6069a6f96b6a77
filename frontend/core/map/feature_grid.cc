#include "frontend/core/map/feature_grid.h"

namespace gw::frontend {

void FeatureGrid::Build(const std::vector<Feature>& features, int width, int height) {
  columns_ = static_cast<int>(width / kCell) + 1;
  rows_ = static_cast<int>(height / kCell) + 1;
  const auto cell_of = [this](const Feature& f) {
    return Clamp(static_cast<int>(f.v / kCell), rows_) * columns_ +
           Clamp(static_cast<int>(f.u / kCell), columns_);
  };
  // Counting sort; features keep their order inside a cell.
  start_.assign(static_cast<size_t>(columns_) * rows_ + 1, 0);
  for (const Feature& f : features) ++start_[cell_of(f) + 1];
  for (size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
  entries_.resize(features.size());
  std::vector<int> next(start_.begin(), start_.end() - 1);
  for (size_t i = 0; i < features.size(); ++i) {
    entries_[next[cell_of(features[i])]++] = {features[i].u, features[i].v, static_cast<int>(i)};
  }
}

}  // namespace gw::frontend

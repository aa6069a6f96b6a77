#include "tools/import/streams.h"

#include <tuple>

namespace gw::importer {

std::vector<std::pair<size_t, size_t>> AssociateNearest(const std::vector<Utime>& a,
                                                        const std::vector<Utime>& b,
                                                        DurationUs max_difference) {
  std::vector<std::tuple<int64_t, size_t, size_t>> candidates;
  size_t first = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    while (first < b.size() && a[i] - b[first] >= max_difference) ++first;
    for (size_t j = first; j < b.size() && b[j] - a[i] < max_difference; ++j) {
      const int64_t difference = (a[i] - b[j]).us;
      candidates.emplace_back(difference < 0 ? -difference : difference, i, j);
    }
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<bool> a_used(a.size()), b_used(b.size());
  std::vector<std::pair<size_t, size_t>> pairs;
  for (const auto& [difference, i, j] : candidates) {
    if (a_used[i] || b_used[j]) continue;
    a_used[i] = b_used[j] = true;
    pairs.emplace_back(i, j);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

double MedianRateHz(const std::vector<Utime>& times) {
  if (times.size() < 2) return 0;
  const size_t step = times.size() < 30 ? 1 : 10;
  std::vector<int64_t> spans;
  for (size_t i = step; i < times.size(); ++i) spans.push_back((times[i] - times[i - step]).us);
  const auto middle = spans.begin() + static_cast<int64_t>(spans.size() / 2);
  std::nth_element(spans.begin(), middle, spans.end());
  return *middle > 0 ? 1e6 * static_cast<double>(step) / static_cast<double>(*middle) : 0;
}

}  // namespace gw::importer

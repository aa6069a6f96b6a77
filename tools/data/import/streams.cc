#include "tools/data/import/streams.h"

#include <optional>

#include "common/core/median.h"
#include "tools/data/files/format.h"

namespace gw::importer {

std::vector<std::pair<size_t, size_t>> AssociateNearest(const std::vector<Utime>& a,
                                                        const std::vector<Utime>& b,
                                                        DurationUs max_difference) {
  std::vector<std::pair<size_t, size_t>> pairs;
  size_t j = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const auto distance = [&](size_t k) { return a[i] < b[k] ? b[k] - a[i] : a[i] - b[k]; };
    while (j + 1 < b.size() && distance(j + 1) < distance(j)) ++j;
    if (j < b.size() && distance(j) < max_difference) pairs.emplace_back(i, j);
  }
  return pairs;
}

DurationUs LargestEyeDifference(const std::vector<Utime>& left) {
  const double rate_hz = MedianRateHz(left);
  return rate_hz > 0 ? DurationUs{static_cast<int64_t>(0.25e6 / rate_hz)} : Milliseconds(1);
}

std::vector<std::pair<size_t, size_t>> PairEyes(const std::vector<Utime>& left,
                                                const std::vector<Utime>& right,
                                                std::vector<std::string>& warnings) {
  std::vector<std::pair<size_t, size_t>> pairs;
  int64_t widest_us = 0;
  for (const auto& [i, j] : AssociateNearest(left, right, LargestEyeDifference(left))) {
    if (!pairs.empty() && pairs.back().second == j) continue;
    pairs.emplace_back(i, j);
    widest_us = std::max(widest_us, std::abs(left[i].us - right[j].us));
  }
  if (widest_us > 1000) {
    warnings.push_back(tools::Format(
        "the eyes are stamped up to %.1f ms apart; a pair is taken as one instant, so that depth "
        "is wrong while the robot turns unless the eyes are triggered together",
        static_cast<double>(widest_us) * 1e-3));
  }
  return pairs;
}

double MedianRateHz(const std::vector<Utime>& times) {
  if (times.size() < 2) return 0;
  const size_t step = times.size() < 30 ? 1 : 10;
  std::vector<int64_t> spans;
  for (size_t i = step; i < times.size(); ++i) spans.push_back((times[i] - times[i - step]).us);
  const int64_t median = MedianOf(&spans);
  return median > 0 ? 1e6 * static_cast<double>(step) / static_cast<double>(median) : 0;
}

}  // namespace gw::importer

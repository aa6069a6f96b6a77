// Making streams of samples well-formed, and pairing two of them by time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/core/result.h"
#include "common/core/time.h"

namespace gw::importer {

// Sorts samples by time and drops those that repeat a time (the first in the file stays). Returns
// how many were dropped; both cases occur in published recordings, neither may reach a log.
template <typename Sample>
int64_t SortAndDropRepeats(std::vector<Sample>& samples, bool& was_unsorted) {
  const auto earlier = [](const Sample& a, const Sample& b) { return a.utime < b.utime; };
  was_unsorted = !std::is_sorted(samples.begin(), samples.end(), earlier);
  if (was_unsorted) std::stable_sort(samples.begin(), samples.end(), earlier);
  const auto same = [](const Sample& a, const Sample& b) { return a.utime == b.utime; };
  const auto end = std::unique(samples.begin(), samples.end(), same);
  const int64_t dropped = samples.end() - end;
  samples.erase(end, samples.end());
  return dropped;
}

// The same, with the warning that a user should see. Error kBadData when more records repeat a time
// than have one of their own: then the times have lost their digits, or are not those of the
// measurements.
template <typename Sample>
Result<Done> MakeOrdered(std::vector<Sample>& samples, const std::string& file,
                         std::vector<std::string>& warnings) {
  const size_t total = samples.size();
  bool was_unsorted = false;
  const int64_t dropped = SortAndDropRepeats(samples, was_unsorted);
  if (was_unsorted) warnings.push_back(file + ": times do not increase; sorted");
  if (dropped == 0) return Done{};
  const std::string repeats = file + ": " + std::to_string(dropped) + " of " +
                              std::to_string(total) + " records repeat a time";
  if (dropped > std::ssize(samples)) {
    return Error{ErrorCode::kBadData,
                 repeats +
                     "; did the times lose digits when they were written? Write seconds with "
                     "six decimals"};
  }
  warnings.push_back(repeats + "; the first of each was kept");
  return Done{};
}

// Pairs (index in a, index in b): for each of a the nearest of b, if their times differ by less
// than max_difference. One of b may serve two of a: no image of `a` is left out because its
// neighbour was nearer to the only depth image between them. Both inputs increase.
std::vector<std::pair<size_t, size_t>> AssociateNearest(const std::vector<Utime>& a,
                                                        const std::vector<Utime>& b,
                                                        DurationUs max_difference);

// The eyes of a stereo camera by their stamps, one to one, within a quarter of a frame's time of
// the left eye: beyond it the robot has moved between them, and they are no pair. Warns of eyes
// that are apart by more than the jitter of a stamp (1 ms). Both inputs increase.
std::vector<std::pair<size_t, size_t>> PairEyes(const std::vector<Utime>& left,
                                                const std::vector<Utime>& right,
                                                std::vector<std::string>& warnings);
// That quarter of a frame's time; with fewer than two times 1 ms.
DurationUs LargestEyeDifference(const std::vector<Utime>& left);

// Median of the spans of ten samples (with fewer than 30 times: of one) as a rate, so that neither
// jitter nor gaps count; 0 with fewer than two times.
double MedianRateHz(const std::vector<Utime>& times);

}  // namespace gw::importer

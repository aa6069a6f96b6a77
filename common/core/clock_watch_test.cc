#include "common/core/clock_watch.h"

#include <gtest/gtest.h>

#include <vector>

namespace gw {
namespace {

using enum ClockWatch::Verdict;

std::vector<ClockWatch::Verdict> Judge(const std::vector<int64_t>& times) {
  ClockWatch watch;
  std::vector<ClockWatch::Verdict> out;
  for (const int64_t us : times) out.push_back(watch.Judge(Utime{us}));
  return out;
}

TEST(ClockWatch, LateAndRepeatedSamplesAreNoClockSetBack) {
  EXPECT_EQ(Judge({10, 20, 15, 30}), (std::vector{kInOrder, kInOrder, kLate, kInOrder}));
  EXPECT_EQ(Judge({10, 10, 10, 10, 10}), (std::vector{kInOrder, kLate, kLate, kLate, kLate}));
  EXPECT_EQ(Judge({10, 50, 20, 30, 60}), (std::vector{kInOrder, kInOrder, kLate, kLate, kInOrder}));
  EXPECT_EQ(Judge({50, 40, 30, 20, 10}), (std::vector{kInOrder, kLate, kLate, kLate, kLate}));
}

TEST(ClockWatch, SamplesInOrderBehindTheNewestShowIt) {
  EXPECT_EQ(Judge({1000, 10, 20, 30, 40, 50}),
            (std::vector{kInOrder, kLate, kLate, kSetBack, kInOrder, kInOrder}));
}

}  // namespace
}  // namespace gw

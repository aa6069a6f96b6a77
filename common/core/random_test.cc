#include "common/core/random.h"

#include <gtest/gtest.h>

namespace gw {
namespace {

TEST(CounterRng, DependsOnlyOnItsThreeKeys) {
  CounterRng a(7, 1, 5);
  CounterRng b(7, 1, 5);
  CounterRng other_index(7, 1, 6);
  CounterRng other_stream(7, 2, 5);
  const uint64_t value = a.NextU64();
  EXPECT_EQ(value, b.NextU64());
  EXPECT_NE(value, other_index.NextU64());
  EXPECT_NE(value, other_stream.NextU64());
}

TEST(CounterRng, NormalHasMeanZeroAndVarianceOne) {
  double sum = 0;
  double sum2 = 0;
  constexpr int kN = 100000;
  CounterRng rng(1, 2, 3);
  for (int i = 0; i < kN; ++i) {
    const double x = rng.Normal();
    sum += x;
    sum2 += x * x;
  }
  EXPECT_NEAR(sum / kN, 0.0, 4.0 / std::sqrt(kN));
  EXPECT_NEAR(sum2 / kN, 1.0, 4.0 * std::sqrt(2.0 / kN));
}

TEST(CounterRng, BelowCoversItsRangeEvenly) {
  int counts[10] = {};
  CounterRng rng(1, 2, 4);
  for (int i = 0; i < 100000; ++i) ++counts[rng.Below(10)];
  for (const int c : counts) EXPECT_NEAR(c, 10000, 500);
}

}  // namespace
}  // namespace gw

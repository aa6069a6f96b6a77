#include "common/core/format.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/core/random.h"

namespace gw {
namespace {

TEST(FormatDouble, KeepsAllDigits) {
  for (int i = 0; i < 1000; ++i) {
    CounterRng rng(8, 0, i);
    const double value = rng.Normal() * std::pow(10.0, rng.Uniform(-300, 300));
    EXPECT_EQ(std::stod(FormatDouble(value)), value);
  }
  EXPECT_EQ(FormatDouble(0.1), "0.1");
  EXPECT_EQ(FormatDouble(100000), "100000");
  EXPECT_EQ(FormatDouble(-2e-5), "-2e-05");
}

TEST(FormatFixed, RoundsAndHasNoNegativeZero) {
  EXPECT_EQ(FormatFixed(1.2345, 2), "1.23");
  EXPECT_EQ(FormatFixed(-0.001, 2), "0.00");
  EXPECT_EQ(FormatFixed(-0.5, 0), "0");
  EXPECT_EQ(FormatFixed(-1.5, 1), "-1.5");
  EXPECT_EQ(FormatFixed(std::numeric_limits<double>::max(), 6).size(), 309u + 7u);
  EXPECT_EQ(FormatFixed(std::nan(""), 3), "nan");
}

}  // namespace
}  // namespace gw

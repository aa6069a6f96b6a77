#include "common/core/median.h"

#include <gtest/gtest.h>

namespace gw {
namespace {

TEST(Median, IsTheValueInTheMiddle) {
  std::vector<double> odd{5, -1, 3};
  EXPECT_EQ(MedianOf(&odd), 3);
  std::vector<int> even{4, 1, 2, 3};
  EXPECT_EQ(MedianOf(&even), 3);
  std::vector<float> one{7};
  EXPECT_EQ(MedianOf(&one), 7);
}

}  // namespace
}  // namespace gw

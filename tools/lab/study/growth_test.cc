#include "tools/lab/study/growth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace gw::study {
namespace {

TEST(GrowthPanels, ShowEveryQuantityOfEveryRunFromZeroToAboveTheLargest) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const GrowthRun da{"da", {{10, 40, 3000, 80, 9.5, none}, {20, 70, 5000, 95, 11, none}}};
  const GrowthRun full{"full", {{10, 50, 3100, 90, 10, 30}, {20, 60, 4000, 100, 9, none}}};
  const std::vector<plot::Panel> panels = GrowthPanels({da, full});
  ASSERT_EQ(panels.size(), 5u);
  const double largest[] = {70, 5000, 100, 11, 30};
  const double last_of_full[] = {60, 4000, 100, 9, none};
  for (size_t i = 0; i < panels.size(); ++i) {
    ASSERT_EQ(panels[i].series.size(), 2u);
    EXPECT_EQ(panels[i].series[1].label, "full");
    EXPECT_EQ(panels[i].series[1].x, (std::vector<double>{10, 20}));
    const double last = panels[i].series[1].y.back();
    EXPECT_TRUE(last == last_of_full[i] || (std::isnan(last) && std::isnan(last_of_full[i])));
    EXPECT_EQ(panels[i].y_range->first, 0);
    EXPECT_NEAR(panels[i].y_range->second, 1.1 * largest[i], 1e-9);
  }
}

}  // namespace
}  // namespace gw::study

#include "backend/core/map/feature_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "common/core/random.h"

namespace gw::backend {
namespace {

TEST(FeatureGrid, FindsEveryFeatureThatIsNear) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    CounterRng rng(seed, 1, 0);
    std::vector<Feature> features(rng.Below(300));
    for (Feature& f : features) {
      f.u = static_cast<float>(rng.Uniform(-50, 700));
      f.v = static_cast<float>(rng.Uniform(-50, 500));
    }
    const FeatureGrid grid(features);
    for (int query = 0; query < 20; ++query) {
      const double u = rng.Uniform(-200, 900);
      const double v = rng.Uniform(-200, 700);
      const double radius = rng.Uniform(0, 80);
      std::vector<int> found;
      grid.Near(u, v, radius, found);
      std::sort(found.begin(), found.end());
      EXPECT_TRUE(std::adjacent_find(found.begin(), found.end()) == found.end());
      for (int i = 0; i < static_cast<int>(features.size()); ++i) {
        if (std::hypot(features[i].u - u, features[i].v - v) > radius) continue;
        EXPECT_TRUE(std::binary_search(found.begin(), found.end(), i)) << seed;
      }
    }
  }
}

TEST(FeatureGrid, FindsNothingAtNowhere) {
  const FeatureGrid grid(std::vector<Feature>(3));
  std::vector<int> found;
  grid.Near(std::numeric_limits<double>::quiet_NaN(), 0, 10, found);
  grid.Near(std::numeric_limits<double>::infinity(), 0, 10, found);
  FeatureGrid().Near(0, 0, 10, found);
  EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace gw::backend

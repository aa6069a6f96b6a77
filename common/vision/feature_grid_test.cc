#include "common/vision/feature_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "common/core/random.h"

namespace gw {
namespace {

TEST(FeatureGrid, FindsTheFeaturesInsideTheSquareAndNoOther) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    CounterRng rng(seed, 1, 0);
    std::vector<Feature> features(rng.Below(300));
    for (Feature& f : features) {
      f.u = static_cast<float>(rng.Uniform(-50, 700));
      f.v = static_cast<float>(rng.Uniform(-50, 500));
    }
    const FeatureGrid grid(features);
    for (int query = 0; query < 20; ++query) {
      const auto u = static_cast<float>(rng.Uniform(-200, 900));
      const auto v = static_cast<float>(rng.Uniform(-200, 700));
      const auto radius = static_cast<float>(rng.Uniform(0, 80));
      std::vector<int> found;
      grid.ForEachNear(u, v, radius, [&](int i) { found.push_back(i); });
      std::sort(found.begin(), found.end());
      EXPECT_TRUE(std::adjacent_find(found.begin(), found.end()) == found.end());
      for (int i = 0; i < static_cast<int>(features.size()); ++i) {
        const bool inside =
            std::abs(features[i].u - u) <= radius && std::abs(features[i].v - v) <= radius;
        EXPECT_EQ(std::binary_search(found.begin(), found.end(), i), inside) << seed;
      }
    }
  }
}

TEST(FeatureGrid, FindsNothingAtNowhere) {
  const FeatureGrid grid(std::vector<Feature>(3));
  const auto fail = [](int) { ADD_FAILURE(); };
  grid.ForEachNear(std::numeric_limits<float>::quiet_NaN(), 0, 10, fail);
  grid.ForEachNear(std::numeric_limits<float>::infinity(), 0, 10, fail);
  FeatureGrid().ForEachNear(0, 0, 10, fail);
}

}  // namespace
}  // namespace gw

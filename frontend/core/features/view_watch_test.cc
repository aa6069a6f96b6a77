#include "frontend/core/features/view_watch.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/random.h"

namespace gw::frontend {
namespace {

constexpr int64_t kImageUs = 100'000;
constexpr int kFeatures = 400;
constexpr double kWidth = 640;

class ViewWatchTest : public testing::Test {
 protected:
  // Images with features anywhere between two columns, px; what is expected lies as far as `beside`
  // these, px, and is found where features are.
  void Show(int images, double from, double to, double beside, double gain = 1) {
    for (int i = 0; i < images; ++i) {
      FeatureFrame frame;
      frame.features.resize(kFeatures);
      for (Feature& f : frame.features) f.u = static_cast<float>(random_.Uniform(from, to));
      const double sun = 100 + 50 * std::sin(0.3 * static_cast<double>(images_));
      frame.brightness = (images_ % 2 == 0 ? 1 / gain : gain) * sun;
      for (int k = 0; k < kFeatures / 2; ++k) {
        const double u = random_.Uniform(from - beside, to + beside);
        if (u < 0 || u >= kWidth) continue;
        watch_.Expect(u, u >= from && u < to && random_.Uniform(0, 1) < 0.8);
      }
      watch_.Observe({++images_ * kImageUs}, frame);
    }
  }

  ViewWatch watch_{kWidth};
  CounterRng random_{1, 0, 0};
  int64_t images_ = 0;
};

TEST_F(ViewWatchTest, AHealthyViewHasNoFault) {
  Show(200, 0, kWidth, 0);
  EXPECT_EQ(watch_.fault(), ViewFault::kNone);
}

TEST_F(ViewWatchTest, ABlankWallOnOneSideLosesNothing) {
  Show(600, 0.5 * kWidth, kWidth, 0);
  EXPECT_EQ(watch_.fault(), ViewFault::kNone);
}

TEST_F(ViewWatchTest, TheMarginOfTheImageIsNoCover) {
  Show(600, 25, kWidth - 25, 25);
  EXPECT_EQ(watch_.fault(), ViewFault::kNone);
}

TEST_F(ViewWatchTest, ACoveredSideIsNamed) {
  for (const double share : {0.3, 0.5, 0.6}) {
    watch_ = ViewWatch(kWidth);
    Show(60, share * kWidth, kWidth, 30);
    EXPECT_EQ(watch_.fault(), ViewFault::kLeftCovered) << share;
    watch_ = ViewWatch(kWidth);
    Show(60, 0, (1 - share) * kWidth, 30);
    EXPECT_EQ(watch_.fault(), ViewFault::kRightCovered) << share;
  }
  Show(2000, 0, kWidth, 0);
  EXPECT_EQ(watch_.fault(), ViewFault::kNone) << "wiped";
}

TEST_F(ViewWatchTest, DarknessIsNoCover) {
  Show(60, 0, kWidth, 0);
  for (int i = 0; i < 600; ++i) watch_.Observe({++images_ * kImageUs}, FeatureFrame());
  EXPECT_EQ(watch_.fault(), ViewFault::kNone);
}

TEST_F(ViewWatchTest, LightThatJumpsIsNamed) {
  Show(5, 0, kWidth, 0, 1.3);
  EXPECT_EQ(watch_.fault(), ViewFault::kNone) << "too early";
  Show(20, 0, kWidth, 0, 1.3);
  EXPECT_EQ(watch_.fault(), ViewFault::kFlickers);
  Show(30, 0, kWidth, 0, 1.02);
  EXPECT_EQ(watch_.fault(), ViewFault::kNone);
}

TEST_F(ViewWatchTest, OneSwitchOfTheLightIsNoFlicker) {
  for (int i = 0; i < 40; ++i) {
    FeatureFrame frame;
    frame.brightness = i < 20 ? 10 : 120;
    watch_.Observe({++images_ * kImageUs}, frame);
    EXPECT_EQ(watch_.fault(), ViewFault::kNone);
  }
}

}  // namespace
}  // namespace gw::frontend

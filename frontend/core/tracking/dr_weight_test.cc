#include "frontend/core/tracking/dr_weight.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "common/core/random.h"

namespace gw::frontend {
namespace {

const DrWeightConfig kPaper;

TEST(DrWeight, AlphaIsMaxWhenNothingIsSeenAndMinWhenAllIsWell) {
  EXPECT_EQ(InformationScale(Quality({0, 0}, kPaper), kPaper), kPaper.alpha_max);
  EXPECT_EQ(InformationScale(Quality({600, 120}, kPaper), kPaper), kPaper.alpha_min);
  EXPECT_EQ(InformationScale(Quality({5000, 5000}, kPaper), kPaper), kPaper.alpha_min);
}

TEST(DrWeight, HalfQualityIsTheGeometricMean) {
  EXPECT_DOUBLE_EQ(Quality({600, 0}, kPaper), 0.5);
  EXPECT_NEAR(InformationScale(0.5, kPaper), std::sqrt(kPaper.alpha_min * kPaper.alpha_max), 1e-12);
}

TEST(DrWeight, QualityStaysInRangeAndAlphaFallsWithIt) {
  for (int i = 0; i < 300; ++i) {
    CounterRng rng(1, 0, i);
    const TrackingHealth health{static_cast<int>(rng.Below(2000)),
                                static_cast<int>(rng.Below(600))};
    const double q = Quality(health, kPaper);
    ASSERT_GE(q, 0.0);
    ASSERT_LE(q, 1.0);
    const double better = Quality({health.num_detected + 10, health.num_tracked + 10}, kPaper);
    EXPECT_GE(better, q);
    EXPECT_LE(InformationScale(better, kPaper), InformationScale(q, kPaper));
  }
}

TEST(DrWeight, VariantsUseTheirOwnScale) {
  const auto expect = [](Variant variant, double q, double scale) {
    const DrScale got = VariantScale(variant, q, q, kPaper);
    EXPECT_EQ(got.translation, scale);
    EXPECT_EQ(got.rotation, scale);
  };
  expect(Variant::kNone, 0.1, 0.0);
  expect(Variant::kDa, 0.1, 0.0);
  expect(Variant::kPe, 0.1, InformationScale(0.1, kPaper));
  expect(Variant::kFixed, 0.1, kPaper.fixed_alpha);
  expect(Variant::kSwitch, 0.1, kDrAlone);
  expect(Variant::kSwitch, 0.9, 0.0);
}

TEST(DrWeight, FarFeaturesAloneLeaveTheTranslationToDeadReckoning) {
  const DrScale far = VariantScale(Variant::kFull, 1.0, 0.0, kPaper);
  EXPECT_EQ(far.rotation, kPaper.alpha_min);
  EXPECT_EQ(far.translation, kPaper.alpha_max);
}

TEST(DrWeight, CovarianceIsNominalPerFrameUnlessTheFilterSaysMore) {
  const Matrix6d nominal = DrCovariance({100000}, Matrix6d::Zero(), kPaper);  // three frames
  EXPECT_NEAR(nominal(0, 0), 3 * 0.004 * 0.004, 1e-12);
  EXPECT_NEAR(nominal(5, 5), 3 * std::pow(0.1 * M_PI / 180, 2), 1e-12);
  Matrix6d filter = Matrix6d::Zero();
  filter(1, 1) = 0.5;
  const Matrix6d larger = DrCovariance({100000}, filter, kPaper);
  EXPECT_EQ(larger(1, 1), 0.5);
  EXPECT_EQ(larger(0, 0), nominal(0, 0));
  EXPECT_GT(larger.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0.0);
}

}  // namespace
}  // namespace gw::frontend

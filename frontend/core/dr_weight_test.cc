#include "frontend/core/dr_weight.h"

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
  EXPECT_EQ(VariantScale(Variant::kNone, 0.1, kPaper), 0.0);
  EXPECT_EQ(VariantScale(Variant::kDa, 0.1, kPaper), 0.0);
  EXPECT_EQ(VariantScale(Variant::kPe, 0.1, kPaper), InformationScale(0.1, kPaper));
  EXPECT_EQ(VariantScale(Variant::kFixed, 0.1, kPaper), kPaper.fixed_alpha);
  EXPECT_EQ(VariantScale(Variant::kSwitch, 0.1, kPaper), kDrAlone);
  EXPECT_EQ(VariantScale(Variant::kSwitch, 0.9, kPaper), 0.0);
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

#include "common/good_weights/alpha.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "common/core/random.h"
#include "common/good_weights/covariance.h"
#include "common/good_weights/quality.h"

namespace gw {
namespace {

const DrWeightConfig kPaper;

TEST(GoodWeights, AlphaIsMaxWhenNothingIsSeenAndMinWhenAllIsWell) {
  EXPECT_EQ(InformationScale(ImageQuality({0, 0}, kPaper), kPaper), kPaper.alpha_max);
  EXPECT_EQ(InformationScale(ImageQuality({600, 120}, kPaper), kPaper), kPaper.alpha_min);
  EXPECT_EQ(InformationScale(ImageQuality({5000, 5000}, kPaper), kPaper), kPaper.alpha_min);
}

TEST(GoodWeights, HalfQualityIsTheGeometricMean) {
  EXPECT_DOUBLE_EQ(ImageQuality({600, 0}, kPaper), 0.5);
  EXPECT_NEAR(InformationScale(0.5, kPaper), std::sqrt(kPaper.alpha_min * kPaper.alpha_max), 1e-12);
}

TEST(GoodWeights, QualityStaysInRangeAndAlphaFallsWithIt) {
  for (int i = 0; i < 300; ++i) {
    CounterRng rng(1, 0, i);
    const TrackingHealth health{static_cast<int>(rng.Below(2000)),
                                static_cast<int>(rng.Below(600))};
    const double q = ImageQuality(health, kPaper);
    ASSERT_GE(q, 0.0);
    ASSERT_LE(q, 1.0);
    const double better = ImageQuality({health.num_detected + 10, health.num_tracked + 10}, kPaper);
    EXPECT_GE(better, q);
    EXPECT_LE(InformationScale(better, kPaper), InformationScale(q, kPaper));
  }
}

TEST(GoodWeights, VariantsUseTheirOwnScale) {
  const auto expect = [](Variant variant, double q, double scale) {
    const DrScale got = PriorScale(variant, q, q, kPaper);
    EXPECT_EQ(got.translation, scale);
    EXPECT_EQ(got.rotation, scale);
  };
  expect(Variant::kNone, 0.1, 0.0);
  expect(Variant::kDa, 0.1, 0.0);
  expect(Variant::kPe, 0.1, InformationScale(0.1, kPaper));
  expect(Variant::kFixed, 0.1, kPaper.fixed_alpha);
  expect(Variant::kSwitch, 0.1, kPaper.alpha_max);
  expect(Variant::kSwitch, 0.9, 0.0);
}

TEST(GoodWeights, FarFeaturesAloneLeaveTheTranslationToDeadReckoning) {
  const DrScale far = PriorScale(Variant::kFull, 1.0, 0.0, kPaper);
  EXPECT_EQ(far.rotation, kPaper.alpha_min);
  EXPECT_EQ(far.translation, kPaper.alpha_max);
}

// Equations of section III of Du, Peng, Vela, "Good Weights", arXiv 2509.22910, with its numbers,
// by hand.
TEST(GoodWeights, IsThePapersLaw) {
  EXPECT_NEAR(ImageQuality({300, 60}, kPaper), 0.5 * 0.5 + 0.5 * 0.5, 1e-12);
  EXPECT_NEAR(ImageQuality({450, 30}, kPaper), 0.5 * 0.75 + 0.5 * 0.25, 1e-12);
  EXPECT_NEAR(InformationScale(0.75, kPaper), 1.0, 1e-12);  // 0.1 * 10000^0.25
  EXPECT_NEAR(InformationScale(0.25, kPaper), 100.0, 1e-9);
}

TEST(GoodWeights, EdgesFollowTheVariant) {
  for (const Variant v : {Variant::kNone, Variant::kDa, Variant::kPe}) {
    EXPECT_EQ(EdgeScale(v, 0, kPaper), 0);
  }
  for (const Variant v : {Variant::kLba, Variant::kFull}) {
    EXPECT_EQ(EdgeScale(v, 1, kPaper), kPaper.alpha_min);
    EXPECT_EQ(EdgeScale(v, 0, kPaper), kPaper.alpha_max);
    EXPECT_EQ(EdgeScale(v, 0.4, kPaper), PriorScale(v, 0.4, 0.4, kPaper).rotation)
        << "one law for images and edges";
  }
  EXPECT_EQ(EdgeScale(Variant::kFixed, 0.7, {.fixed_alpha = 7}), 7);
  EXPECT_EQ(EdgeScale(Variant::kSwitch, 0.5, {.switch_q = 0.3}), 0);
  EXPECT_EQ(EdgeScale(Variant::kSwitch, 0.2, {.switch_q = 0.3}), 1e3);
}

TEST(GoodWeights, AnEdgeIsAsGoodAsItsConnectionAndItsNewerImage) {
  EXPECT_EQ(EdgeQuality(50, 100, 1.0), 0.5);
  EXPECT_EQ(EdgeQuality(50, 100, 0.3), 0.3);
  EXPECT_EQ(EdgeQuality(500, 100, 1.0), 1.0);
  EXPECT_EQ(EdgeQuality(0, 100, 1.0), 0.0);
  EXPECT_EQ(LackReaching(0.8, 0), 0.8);
  EXPECT_EQ(LackReaching(0.8, 3), 0.1);
}

TEST(GoodWeights, CovarianceIsNominalPerFrameUnlessTheFilterSaysMore) {
  const Matrix6d nominal = DrCovariance({100000}, Matrix6d::Zero(), kPaper);  // three frames
  EXPECT_NEAR(nominal(0, 0), 3 * 0.004 * 0.004, 1e-12);
  EXPECT_NEAR(nominal(5, 5), 3 * std::pow(0.1 * M_PI / 180, 2), 1e-12);
  Matrix6d filter = Matrix6d::Zero();
  filter(1, 1) = 0.5;
  const Matrix6d larger = DrCovariance({100000}, filter, kPaper);
  EXPECT_NEAR(larger(1, 1), 0.5, 1e-12);
  EXPECT_NEAR(larger(0, 0), nominal(0, 0), 1e-15);
  EXPECT_GT(larger.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0.0);
}

TEST(GoodWeights, ScalingIsPerBlockAndNotBelowWhatIsHonest) {
  const Matrix6d cov = Matrix6d::Identity();
  const Matrix6d scaled = ScaledCovariance(cov, {4, 100}, Matrix6d::Zero());
  EXPECT_DOUBLE_EQ(scaled(0, 0), 1.0 / 4);
  EXPECT_DOUBLE_EQ(scaled(5, 5), 1.0 / 100);
  const Matrix6d bounded = ScaledCovariance(cov, {4, 100}, 0.1 * Matrix6d::Identity());
  EXPECT_NEAR(bounded(0, 0), 1.0 / 4, 1e-12);
  EXPECT_NEAR(bounded(5, 5), 0.1, 1e-12);
}

}  // namespace
}  // namespace gw

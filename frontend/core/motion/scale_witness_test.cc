#include "frontend/core/motion/scale_witness.h"

#include <gtest/gtest.h>

namespace gw::frontend {
namespace {

// A filter that began with `prior` and by now takes the wheels' scale to be this.
ScaleWitness Witness(double prior, double scale, double sigma) {
  ScaleWitness witness;
  DrState told;
  told.way_scale_sigma = prior;
  witness.Observe(told);
  told.wheel_scale = scale;
  told.way_scale_sigma = sigma;
  witness.Observe(told);
  return witness;
}

TEST(ScaleWitness, SaysNothingOfWhatWasAssumed) {
  EXPECT_EQ(ScaleWitness().LogOddsForDr(1.2), 0);
  EXPECT_EQ(Witness(0.01, 1, 0.01).LogOddsForDr(1.2), 0);
  EXPECT_EQ(Witness(0, 1, 0).LogOddsForDr(1.2), 0) << "a source that tells no sigma";
}

TEST(ScaleWitness, IsAsSureAsTheMeasurementBehindThePosterior) {
  // A prior of 1 +- 0.01 and a measurement of 1.003 +- 0.02.
  const double prior = 1 / (0.01 * 0.01), measured = 1 / (0.02 * 0.02);
  const double scale = (prior + measured * 1.003) / (prior + measured);
  const ScaleWitness witness = Witness(0.01, scale, 1 / std::sqrt(prior + measured));
  // ... of an accelerometer whose own scale is known to a per cent.
  const auto misfit = [](double of) { return std::pow((1.003 - of) / std::hypot(0.02, 0.01), 2); };
  EXPECT_NEAR(witness.LogOddsForDr(1.1), 0.5 * (misfit(scale * 1.1) - misfit(scale)), 1e-6);
  EXPECT_GT(witness.LogOddsForDr(1.1), 5);
  EXPECT_GT(witness.LogOddsForDr(0.9), 5);
  EXPECT_LT(witness.LogOddsForDr(1.01), 1) << "too little to tell";
}

TEST(ScaleWitness, SpeaksForVisionWhereTheAccelerometerSeesItsLengths) {
  EXPECT_LT(Witness(0.01, 0.93, 0.007).LogOddsForDr(0.9), -5);
}

TEST(ScaleWitness, ForgetsWithTheFilterThatBeginsAnew) {
  ScaleWitness witness = Witness(0.01, 1, 0.007);
  EXPECT_GT(witness.LogOddsForDr(1.2), 5);
  DrState anew;
  anew.reset_counter = 1;
  anew.way_scale_sigma = 0.007;
  witness.Observe(anew);
  EXPECT_EQ(witness.LogOddsForDr(1.2), 0);
}

TEST(LengthFault, TellsTheValueToSet) {
  EXPECT_EQ(Describe(LengthFault{}), "");
  EXPECT_NE(Describe(LengthFault{1.25, true}).find("by 0.800"), std::string::npos);
  EXPECT_EQ(Describe(LengthFault{1.25, false}).find("taken out"), std::string::npos);
}

}  // namespace
}  // namespace gw::frontend

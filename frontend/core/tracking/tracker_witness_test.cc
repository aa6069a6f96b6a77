// The tracker in a synthetic room, where dead reckoning or vision is wrong.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "common/vision/scale_lengths.h"
#include "frontend/core/tracking/tracker_test_room.h"
#include "frontend/core/tracking/witnesses.h"

namespace gw::frontend {
namespace {

TEST(Tracker, HealthyVisionIgnoresBadDeadReckoning) {
  const Recording none = Drive(Variant::kNone, 200, 0, 0, 0);
  const Recording full = Drive(Variant::kFull, 200, 0, 0, 1.05);
  EXPECT_LT(full.errors_m.back(), none.errors_m.back() + 0.005);
}

// Wrong units, signs and stuck headings: healthy vision is not pulled, and says who is wrong.
TEST(Tracker, DeadReckoningThatContradictsHealthyVisionIsNamedAndNotUsed) {
  // Full health (Q of 0.9 and more) only comes when the circle has been mapped once.
  constexpr int kImages = 450;
  const Recording none = Drive(Variant::kNone, kImages, 0, 0, 0);
  // The heading stands.
  const Recording full = Drive(Variant::kFull, kImages, 0, 0, 1, 0);
  // What was mapped in the seconds before it is noticed stays bent here: there is no back-end.
  EXPECT_LT(full.errors_m.back(), none.errors_m.back() + 0.05);
  EXPECT_EQ(full.poses.back().reason, TrackingReason::kDrContradictsVision);
  EXPECT_EQ(full.poses.back().status, TrackingStatus::kDegraded);
  EXPECT_FALSE(full.keyframes.back().dr) << "no edge of it goes into the map";
  for (size_t i = kImages - 60; i < full.poses.size(); ++i) {
    EXPECT_EQ(full.poses[i].reason, TrackingReason::kDrContradictsVision) << i;
  }
  const Recording sound = Drive(Variant::kFull, kImages, 0, 0, 1);
  for (const FramePose& pose : sound.poses) EXPECT_EQ(pose.reason, TrackingReason::kNone);
  EXPECT_TRUE(sound.dr_fault.empty());
}

// Two seconds of dark after ten of light, in which vision has measured the constant.
TEST(Tracker, AConstantByWhichDeadReckoningIsWrongIsTakenOutOfIt) {
  constexpr int kImages = 420, kDark = 330, kLight = 390;
  const Recording sound = Drive(Variant::kFull, kImages, kDark, kLight, 1);
  for (const double way : {2.0, 0.5, 0.001, 10.0}) {
    const Recording full = Drive(Variant::kFull, kImages, kDark, kLight, way);
    ASSERT_TRUE(full.dr_fault.way_factor) << way;
    EXPECT_NEAR(*full.dr_fault.way_factor * way, 1, 0.05);
    EXPECT_FALSE(full.dr_fault.turn_factor);
    // The robot drives a metre in the dark.
    EXPECT_LT(full.errors_m[kLight - 1], sound.errors_m[kLight - 1] + 0.1) << way;
    EXPECT_EQ(full.poses.back().status, TrackingStatus::kDegraded);
    EXPECT_EQ(full.poses.back().reason, TrackingReason::kNone);
    EXPECT_TRUE(full.keyframes.back().dr);
  }
  const Recording turned = Drive(Variant::kFull, kImages, kDark, kLight, 1, -1);
  ASSERT_TRUE(turned.dr_fault.turn_factor);
  EXPECT_NEAR(*turned.dr_fault.turn_factor, -1, 0.05);
  EXPECT_LT(turned.errors_m[kLight - 1], sound.errors_m[kLight - 1] + 0.15);
}

// What the accelerometer has told of the wheels' scale after this image: at first nothing.
void TellScale(int i, DrState* state) {
  state->way_scale_sigma = i == 0 ? 0.01 : 0.008;
  state->cov_twist_white.diagonal() << 1e-5, 1e-6, 1e-6, 1e-7, 1e-7, 1e-7;
}

// As if the baseline were stated too large by this factor.
std::function<void(int, FeatureFrame*)> Lengths(double factor) {
  return [factor](int, FeatureFrame* seen) { ScaleLengths(factor, &seen->features); };
}

TEST(Tracker, LengthsOfTheCameraThatWheelsAndAccelerometerContradictAreCorrected) {
  const FrontendConfig config;
  constexpr int kImages = 300;
  const Recording sound = Drive(config, kImages, 0, 0, 1, 1, 0, nullptr, TellScale);
  EXPECT_FALSE(sound.length_fault.found());
  for (const double factor : {1.2, 1.1, 0.8}) {
    const Recording run = Drive(config, kImages, 0, 0, 1, 1, 0, Lengths(factor), TellScale);
    EXPECT_NEAR(run.length_fault.too_long / factor, 1, 0.02) << factor;
    EXPECT_TRUE(run.length_fault.corrected);
    EXPECT_TRUE(run.dr_fault.empty());
    EXPECT_EQ(run.poses.back().status, TrackingStatus::kDegraded);
    EXPECT_LT(run.errors_m.back(), sound.errors_m.back() + 0.03) << factor;
    EXPECT_EQ(run.keyframes.front().length_factor, 1);
    EXPECT_NEAR(run.keyframes.back().length_factor * run.length_fault.too_long, 1, 1e-9);
    EXPECT_TRUE(run.keyframes.back().dr);
  }
}

TEST(Tracker, WithoutAThirdWitnessAFactorIsOneOfTheWheels) {
  const auto tell = [](int, DrState* state) { TellScale(0, state); };
  const Recording run = Drive(FrontendConfig(), 300, 0, 0, 1, 1, 0, Lengths(1.2), tell);
  EXPECT_FALSE(run.length_fault.found());
  ASSERT_TRUE(run.dr_fault.way_factor);
  EXPECT_NEAR(*run.dr_fault.way_factor, 1.2, 0.05);
}

TEST(Tracker, WheelsThatTheAccelerometerContradictsAreTheOnesThatAreWrong) {
  // Wheels that count twice as far, and an accelerometer that has begun to say so.
  const auto tell = [](int i, DrState* state) {
    TellScale(i, state);
    state->wheel_scale = i == 0 ? 1 : 0.82;
  };
  const Recording run = Drive(FrontendConfig(), 300, 0, 0, 2, 1, 0, nullptr, tell);
  EXPECT_FALSE(run.length_fault.found());
  ASSERT_TRUE(run.dr_fault.way_factor);
  EXPECT_NEAR(*run.dr_fault.way_factor, 0.5, 0.02);
}

// A robot whose wheels count otherwise from image 150 on; until then its accelerometer has agreed.
TEST(Tracker, WheelsThatChangeOnTheWayAreNoFaultOfTheCamera) {
  for (const double factor : {2.0, 1.3, 0.5, -1.0}) {
    SE3 T_OB;
    SE3 before;
    const auto tell = [&](int i, DrState* state) {
      TellScale(i, state);
      const SE3 step = before.inverse() * state->T_OB;
      before = state->T_OB;
      T_OB = T_OB * SE3(step.rotation(), (i < 150 ? 1 : factor) * step.translation());
      state->T_OB = T_OB;
    };
    const Recording run = Drive(FrontendConfig(), 600, 0, 0, 1, 1, 0, nullptr, tell);
    EXPECT_FALSE(run.length_fault.found()) << factor;
    for (const Keyframe& keyframe : run.keyframes) EXPECT_EQ(keyframe.length_factor, 1) << factor;
    EXPECT_LT(run.errors_m.back(), 0.1) << factor;
    EXPECT_EQ(run.poses[300].status, TrackingStatus::kDegraded) << factor;
  }
}

// Wheels that are reset, once. Where things look alike, a few
// of them fit to the wrong prediction and agree with it; the many that fit to vision's own motion
// decide.
TEST(Tracker, AJumpOfDeadReckoningIsNotFollowedWhereThingsLookAlike) {
  constexpr int kImages = 200, kJump = 120;
  struct Jump {
    double way, turn;
  };
  FrontendConfig config;
  config.variant = Variant::kFull;
  const World world(3000, 14);
  for (const auto& [way, turn] : {Jump{0, 0}, Jump{0.08, 0}, Jump{0.08, 0.1}, Jump{5, 1}}) {
    Tracker tracker = *Tracker::Create(config, world.geometry());
    MapUpdate empty;
    empty.snapshot = true;
    ASSERT_TRUE(tracker.Push(empty));
    double error_m = 0;
    for (int i = 0; i < kImages; ++i) {
      DrState s;
      s.utime = {i * kFrameUs};
      s.seq = i + 1;
      s.T_OB = TruePose(i * kFrameUs * 1e-6);
      const SE3 T_WB = s.T_OB;
      if (i >= kJump) s.T_OB = SE3(ExpSO3({0, 0, turn}), {0, way, 0}) * s.T_OB;
      ASSERT_TRUE(tracker.Push(s));
      const TrackerOutput out = tracker.Track(s.utime, s.seq, world.See(T_WB, i, false));
      error_m = std::max(error_m, (out.pose.T_WB.translation() - T_WB.translation()).norm());
    }
    EXPECT_LT(error_m, 0.03) << way << " " << turn;
  }
}

// A narrow view tells way and turn to the side only together: what it leaves open is not moved.
TEST(Witnesses, ASteadyMotionHoldsWhatVisionLeavesOpen) {
  Vector6d sigma;
  sigma << 0.2, 0.001, 0.001, 0.001, 0.001, 0.001;
  PoseEstimate alone;
  alone.T_WC = SE3::Exp((Vector6d() << 0.5, 0.05, 0, 0, 0, 0.02).finished());
  alone.vision_information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  const Matrix6d cov = 0.03 * 0.03 * Matrix6d::Identity();
  const Vector6d held = HeldSteady(SE3(), cov, alone).Log();
  const Vector6d found = alone.T_WC.Log();
  EXPECT_NEAR(held(0), found(0) * 0.0009 / (0.0009 + 0.04), 1e-9);
  for (int i = 1; i < 6; ++i) EXPECT_NEAR(held(i), found(i), 0.002 * std::abs(found(i)) + 1e-12);
}

// Somebody at one metre, whose left edge is at the image's, and whose right edge is at `right` (m,
// from the optical axis): 400 points that hide what is behind.
void PutPerson(double right, int index, FeatureFrame* frame) {
  const RectifiedCamera camera = MakeCameraGeometry(RobotCalibration())->rectified;
  const double edge = camera.Project({right, 0, 1}).x();
  FeatureFrame out;
  for (size_t i = 0; i < frame->features.size(); ++i) {
    if (frame->features[i].u < edge) continue;
    out.features.push_back(frame->features[i]);
    out.descriptors.push_back(frame->descriptors[i]);
  }
  CounterRng cloth(13, 0, 0), noise(13, 1, static_cast<uint64_t>(index));
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d p(right - cloth.Uniform(0, 1.3), cloth.Uniform(-0.6, 0.6), 1);
    Descriptor d;
    for (uint64_t& word : d) word = cloth.NextU64();
    const Eigen::Vector2d uv = camera.Project(p);
    if (!camera.InImage(uv)) continue;
    Feature f;
    f.u = static_cast<float>(uv.x() + 0.4 * noise.Normal());
    f.v = static_cast<float>(uv.y() + 0.4 * noise.Normal());
    f.depth = static_cast<float>(1 + 0.003 * noise.Normal());
    f.u_right = static_cast<float>(f.u - camera.bf() / f.depth);
    out.features.push_back(f);
    out.descriptors.push_back(d);
  }
  out.num_detected = static_cast<int>(out.features.size());
  *frame = out;
}

TEST(Witnesses, OneImageIsNoProof) {
  Witnesses witnesses(nullptr, nullptr);
  const auto at = [](int64_t ms) { return Utime{0} + Milliseconds(ms); };
  witnesses.Accuse(at(0));
  EXPECT_FALSE(witnesses.Refuted(at(0)));
  witnesses.Accuse(at(900));
  EXPECT_FALSE(witnesses.Refuted(at(900)));
  witnesses.Accuse(at(1000));
  EXPECT_TRUE(witnesses.Refuted(at(1100)));
  witnesses.Clear();
  EXPECT_FALSE(witnesses.Refuted(at(1100)));
  witnesses.Accuse(at(1200));
  EXPECT_FALSE(witnesses.Refuted(at(1200)));
}

// Who walks slower than here (1.3 m in 3 s) is followed for a part of a second, or by 2 cm.
TEST(Tracker, APersonWhoWalksByDoesNotCarryThePose) {
  constexpr int kCome = 100, kGo = 300;  // images
  FrontendConfig config;
  config.variant = Variant::kFull;
  const Recording without = Drive(config, 400, 0, 0, 1);
  for (const int walk : {10, 15, 30, 45}) {
    const auto walks_by = [&](int i, FeatureFrame* seen) {
      if (i < kCome || i >= kGo) return;
      const double way = 1.3 * std::min(1.0, static_cast<double>(i - kCome) / walk);
      PutPerson(-0.8 + way, i, seen);
    };
    const Recording with = Drive(config, 400, 0, 0, 1, 1, 0, walks_by);
    for (size_t i = 0; i < with.poses.size(); ++i) {
      EXPECT_LT(with.errors_m[i], without.errors_m[i] + 0.05) << walk << " " << i;
    }
    for (size_t i = kGo - 30; i < kGo; ++i) {
      EXPECT_NE(with.poses[i].status, TrackingStatus::kTracking) << walk << " " << i;
    }
  }
}

}  // namespace
}  // namespace gw::frontend

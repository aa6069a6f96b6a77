#include "frontend/core/tracking/health_cause.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gw::frontend {
namespace {

using testing::HasSubstr;

std::string Cause(TrackingStatus status, TrackingReason reason) {
  FramePose frame;
  frame.status = status;
  frame.reason = reason;
  return HealthCause(frame, DrConstantFault{}, LengthFault{}, ViewFault::kNone);
}

TEST(HealthCause, NothingIsWrongWhileVisionTracks) {
  EXPECT_EQ(Cause(TrackingStatus::kTracking, TrackingReason::kNone), "");
  EXPECT_EQ(Cause(TrackingStatus::kDegraded, TrackingReason::kTooFewInliers), "");
}

TEST(HealthCause, ACoveredLensIsNamedWhileVisionTracks) {
  FramePose frame;
  frame.status = TrackingStatus::kTracking;
  EXPECT_THAT(HealthCause(frame, {}, {}, ViewFault::kLeftCovered), HasSubstr("covered"));
  EXPECT_THAT(HealthCause(frame, {}, {}, ViewFault::kFlickers), HasSubstr("exposure"));
}

TEST(HealthCause, ACameraWithoutDepthIsNamedWhileNoMapBegins) {
  EXPECT_THAT(Cause(TrackingStatus::kInitializing, TrackingReason::kNoMap),
              HasSubstr("unit of depth"));
  EXPECT_THAT(Cause(TrackingStatus::kInitializing, TrackingReason::kOneEyeTwice),
              HasSubstr("one eye comes twice"));
  EXPECT_THAT(Cause(TrackingStatus::kDrOnly, TrackingReason::kEyesExchanged),
              HasSubstr("exchanged"));
}

TEST(HealthCause, WhatSpoilsVisionComesBeforeWhatFollowsFromIt) {
  EXPECT_THAT(Cause(TrackingStatus::kDrOnly, TrackingReason::kFixedInImage),
              HasSubstr("infrared projector"));
  EXPECT_THAT(Cause(TrackingStatus::kDrOnly, TrackingReason::kTooFewMatches),
              HasSubstr("lens and light"));
  EXPECT_THAT(Cause(TrackingStatus::kLost, TrackingReason::kFixedInImage), HasSubstr("neither"));
}

TEST(HealthCause, ARecoveringPoseSaysWhatItDoesNotFitTo) {
  EXPECT_THAT(Cause(TrackingStatus::kRecovering, TrackingReason::kPoseJump),
              HasSubstr("somebody before the camera"));
  EXPECT_THAT(Cause(TrackingStatus::kRecovering, TrackingReason::kPlaceUnknown),
              HasSubstr("drive to where it was made"));
}

TEST(HealthCause, ADistrustedDeadReckoningIsNamed) {
  EXPECT_THAT(Cause(TrackingStatus::kDegraded, TrackingReason::kDrContradictsVision),
              HasSubstr("check wheel calibration"));
}

TEST(HealthCause, AConstantThatIsTakenOutIsNamedWhileVisionTracks) {
  FramePose frame;
  frame.status = TrackingStatus::kTracking;
  DrConstantFault fault;
  fault.way_factor = 2;
  EXPECT_THAT(
      HealthCause(frame, fault, LengthFault{}, ViewFault::kNone),
      testing::AllOf(HasSubstr("is taken out"), HasSubstr("multiply ticks_per_metre by 0.5")));
  EXPECT_THAT(HealthCause(frame, {}, LengthFault{1.25, true}, ViewFault::kNone),
              HasSubstr("by 0.800"));
}

}  // namespace
}  // namespace gw::frontend

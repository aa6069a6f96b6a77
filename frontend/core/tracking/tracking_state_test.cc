#include "frontend/core/tracking/tracking_state.h"

#include <gtest/gtest.h>

namespace gw::frontend {
namespace {

using enum TrackingState;

TEST(TrackingState, VisionOrABegunMapPlacesTheTracker) {
  for (const TrackingState before : {kStart, kUnplaced, kBlind, kTracking}) {
    EXPECT_EQ(NextState(before, {.vision = true}), kTracking);
    EXPECT_EQ(NextState(before, {.begins_map = true}), kTracking);
  }
}

TEST(TrackingState, APlaceOnceKnownIsKeptWithoutVision) {
  EXPECT_EQ(NextState(kStart, {}), kUnplaced);
  EXPECT_EQ(NextState(kUnplaced, {.from_dr = true}), kUnplaced);
  EXPECT_EQ(NextState(kTracking, {}), kBlind);
  EXPECT_EQ(NextState(kBlind, {.unconfirmed = true}), kBlind);
}

TEST(TrackingStatus, SaysWhoCarriesThePose) {
  const ImageOutcome seen{.map_there = true, .vision = true, .from_dr = true};
  EXPECT_EQ(StatusOf(kTracking, seen), TrackingStatus::kTracking);
  ImageOutcome weak = seen;
  weak.dr_share = 0.5;
  EXPECT_EQ(StatusOf(kTracking, weak), TrackingStatus::kDegraded);
  EXPECT_EQ(StatusOf(kTracking, {.map_there = true, .from_dr = true}), TrackingStatus::kDrOnly);
  EXPECT_EQ(StatusOf(kTracking, {.map_there = true}), TrackingStatus::kLost);
}

TEST(TrackingStatus, RecoversWhileAnythingAboutThePlaceIsOpen) {
  ImageOutcome seen{.map_there = true, .vision = true};
  seen.place_known = false;
  EXPECT_EQ(StatusOf(kTracking, seen), TrackingStatus::kRecovering);
  EXPECT_EQ(StatusOf(kBlind, {.map_there = true, .unconfirmed = true}),
            TrackingStatus::kRecovering);
  EXPECT_EQ(StatusOf(kBlind, {.map_there = true, .vision = true, .corrected = true}),
            TrackingStatus::kRecovering);
}

TEST(TrackingStatus, InitializesUntilThereIsAMap) {
  EXPECT_EQ(StatusOf(kStart, {.from_dr = true}), TrackingStatus::kInitializing);
  EXPECT_EQ(StatusOf(kUnplaced, {.begins_map = true}), TrackingStatus::kTracking);
}

TEST(TrackingStatus, OfAnImageThatIsNotNewerDependsOnWhatWasKnown) {
  EXPECT_EQ(StatusOf(kTracking, {.time_reversed = true}), TrackingStatus::kDegraded);
  EXPECT_EQ(StatusOf(kUnplaced, {.time_reversed = true}), TrackingStatus::kLost);
}

}  // namespace
}  // namespace gw::frontend

#include "frontend/core/tracking/keyframe_policy.h"

#include <gtest/gtest.h>

namespace gw::frontend {
namespace {

const FrontendConfig kDefault;

KeyframeEvidence GoodView() {
  return {.since_last = Milliseconds(200),
          .vision = true,
          .num_inliers = 300,
          .num_mapped = 340,
          .num_close_tracked = 280,
          .num_close_untracked = 100,
          .translation_m = 0.1,
          .rotation_rad = 0.05,
          .median_depth_m = 2.0};
}

TEST(KeyframePolicy, GoodViewNeedsNone) {
  EXPECT_FALSE(NeedsKeyframe(GoodView(), kDefault));
}

TEST(KeyframePolicy, LostOverlapNeedsOne) {
  KeyframeEvidence e = GoodView();
  e.num_inliers = 200;
  EXPECT_TRUE(NeedsKeyframe(e, kDefault));
}

TEST(KeyframePolicy, StandingStillNeverNeedsOneHoweverLong) {
  KeyframeEvidence e = GoodView();
  e.translation_m = 0.001;
  e.rotation_rad = 0.001;
  e.since_last = Milliseconds(3600000);
  EXPECT_FALSE(NeedsKeyframe(e, kDefault));
}

TEST(KeyframePolicy, MovingSlowlyNeedsOneInTheEnd) {
  KeyframeEvidence e = GoodView();
  e.since_last = Milliseconds(kDefault.keyframe_max_interval_ms);
  EXPECT_TRUE(NeedsKeyframe(e, kDefault));
}

TEST(KeyframePolicy, TheMapGoesOnWhereLightIsBackButTheOldMapIsNotFound) {
  KeyframeEvidence e;
  e.vision = false;
  e.num_close_untracked = 300;
  EXPECT_FALSE(NeedsKeyframe(e, kDefault)) << "the old map is looked for first";
  e.unmatched_images = 10;
  EXPECT_TRUE(NeedsKeyframe(e, kDefault)) << "also when it stands still";
  e.num_close_untracked = 20;
  EXPECT_FALSE(NeedsKeyframe(e, kDefault)) << "nothing to make landmarks of";
}

TEST(KeyframePolicy, BlindChainGoesByMotionAlone) {
  KeyframeEvidence e;
  e.vision = false;
  e.since_last = Milliseconds(60000);
  EXPECT_FALSE(NeedsKeyframe(e, kDefault));
  e.translation_m = 0.5;
  EXPECT_TRUE(NeedsKeyframe(e, kDefault));
}

}  // namespace
}  // namespace gw::frontend

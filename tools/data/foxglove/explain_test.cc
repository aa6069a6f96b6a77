#include "tools/data/foxglove/explain.h"

#include <gtest/gtest.h>

#include "tools/data/files/json.h"

namespace gw::foxglove {
namespace {

TEST(Explain, SaysWhoCarriesThePoseAndWhy) {
  FramePose pose;
  pose.num_detected = 120;
  pose.num_inliers = 3;
  pose.reason = TrackingReason::kTooFewMatches;
  FrameDetail detail;
  detail.bound = AlphaBound::kCovariance;
  detail.dr_share << 0.99, 0, 0, 0, 0, 0.94;
  EXPECT_EQ(Explain(pose, detail),
            "3 of 120 features show landmarks; turn from dead reckoning 94 %, way 99 % (weight "
            "bounded by the covariance that dead reckoning states): the image does not show what "
            "the map holds here");
}

TEST(Explain, DoesWithoutDetail) {
  FramePose pose;
  pose.num_detected = 500;
  pose.num_inliers = 300;
  EXPECT_EQ(Explain(pose, std::nullopt), "300 of 500 features show landmarks; vision alone");
  pose.dr_share = 0.25;
  EXPECT_EQ(Explain(pose, std::nullopt), "300 of 500 features show landmarks; dead reckoning 25 %");
}

TEST(Explain, APieceOfTheMapIsNamed) {
  FramePose pose;
  pose.reason = TrackingReason::kPlaceUnknown;
  EXPECT_EQ(Explain(pose, std::nullopt, false).find("piece"), std::string::npos);
  EXPECT_NE(Explain(pose, std::nullopt, true).find("in a piece of its own"), std::string::npos);
}

TEST(Explain, WeightsHaveAxesOnlyWhenTheyAreKnown) {
  EXPECT_FALSE(WeightsMessage(FramePose(), std::nullopt).contains("dr_share_axes"));
  FrameDetail detail;
  detail.dr_share[5] = 0.5;
  const Json json = WeightsMessage(FramePose(), detail);
  EXPECT_EQ(json["dr_share_axes"]["yaw"], 0.5);
}

}  // namespace
}  // namespace gw::foxglove

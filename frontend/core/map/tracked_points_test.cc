#include "frontend/core/map/tracked_points.h"

#include <gtest/gtest.h>

namespace gw::frontend {
namespace {

LandmarkId Id(int i) {
  return LandmarkId::From(KeyframeId{1}, i);
}

TEST(FollowMerges, GoesToTheLastOfAChain) {
  std::vector<TrackedPoint> points(2);
  points[0].id = Id(1);
  points[1].id = Id(9);
  FollowMerges({{Id(1), Id(2)}, {Id(2), Id(3)}}, &points);
  EXPECT_EQ(points[0].id, Id(3));
  EXPECT_EQ(points[1].id, Id(9));
}

TEST(FollowMerges, EndsInACircle) {
  std::vector<TrackedPoint> points(1);
  points[0].id = Id(1);
  FollowMerges({{Id(1), Id(2)}, {Id(2), Id(1)}}, &points);
  EXPECT_TRUE(points[0].id == Id(1) || points[0].id == Id(2));
}

}  // namespace
}  // namespace gw::frontend

#include "backend/core/map/map_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "backend/test/world.h"

namespace gw::backend {
namespace {

// A map after a few keyframes with local BA.
Map Driven(int keyframes) {
  return DrivenMap({.num_points = 600, .outlier_share = 0.02}, keyframes);
}

TEST(CheckMap, FindsNothingInWhatTheMapperMade) {
  const MapFaults faults = CheckMap(Driven(25));
  EXPECT_EQ(faults.count, 0) << testing::PrintToString(faults.texts);
}

TEST(CheckMap, NamesALandmarkWithoutItsFeature) {
  Map map = Driven(5);
  const LandmarkId first = map.SortedLandmarkIds().front();
  map.MutableLandmark(first).observations.back().feature_index = LandmarkId::kMaxFeatures - 1;
  const MapFaults faults = CheckMap(map);
  EXPECT_GT(faults.count, 0);
  EXPECT_THAT(faults.texts,
              testing::Contains(testing::HasSubstr("landmark " + std::to_string(first.value))));
}

TEST(CheckMap, NamesAKeyframeFarOut) {
  Map map = Driven(5);
  map.SetPose({3}, SE3(Eigen::Quaterniond::Identity(), {1e9, 0, 0}));
  EXPECT_THAT(CheckMap(map).texts, testing::ElementsAre(testing::HasSubstr("keyframe 3 is not")));
}

TEST(CheckMap, NamesALandmarkNobodySees) {
  Map map = Driven(5);
  map.AddLandmark(LandmarkId::From({5}, 9000));
  EXPECT_THAT(CheckMap(map).texts,
              testing::ElementsAre(testing::HasSubstr("is observed by no keyframe")));
}

TEST(CheckMap, CountsAllAndNamesTheFirst) {
  Map map = Driven(5);
  for (int i = 0; i < 100; ++i) map.AddLandmark(LandmarkId::From({5}, 9000 + i));
  const MapFaults faults = CheckMap(map);
  EXPECT_EQ(faults.count, 100);
  EXPECT_EQ(faults.texts.size(), MapFaults::kMaxTexts);
}

}  // namespace
}  // namespace gw::backend

#include "backend/core/mapping/culling.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "backend/test/world.h"

namespace gw::backend {
namespace {

constexpr int kKeyframes = 20;  // K11 to K20, the ten newest, always stay
constexpr int kFeatures = 300;

class Culling : public testing::Test {
 protected:
  // A chain of keyframes with DR edges between them; features have depth.
  Culling() : context_(MappingContext({}, {}, TestCamera())) {
    for (int k = 1; k <= kKeyframes; ++k) {
      Keyframe keyframe;
      keyframe.id = {k};
      keyframe.utime = {k * 1000};
      keyframe.previous = {k - 1};
      keyframe.q = 1;
      keyframe.dr = DrIncrement{};
      keyframe.dr->utime_begin = {(k - 1) * 1000};
      keyframe.dr->utime_end = keyframe.utime;
      keyframe.features.resize(kFeatures);
      for (Feature& feature : keyframe.features) feature.depth = 2;
      keyframe.descriptors.resize(kFeatures);
      keyframe.landmarks.resize(kFeatures);
      EXPECT_TRUE(map_.AddKeyframe(keyframe));
    }
  }

  // `count` new landmarks, each seen by all of these.
  void See(int count, const std::vector<int>& keyframes) {
    for (int i = 0; i < count; ++i, ++next_feature_) {
      ASSERT_LT(next_feature_, kFeatures);
      const LandmarkId id = LandmarkId::From({keyframes.front()}, next_feature_);
      map_.AddLandmark(id).p_W = {0, 0, 2};
      for (const int k : keyframes) map_.AddObservation(id, {{k}, next_feature_});
    }
  }

  static std::vector<int> All() {
    std::vector<int> all(kKeyframes);
    std::iota(all.begin(), all.end(), 1);
    return all;
  }

  std::vector<int> Gone() {
    CullRedundantKeyframes(map_, context_);
    std::vector<int> gone;
    for (int k = 1; k <= kKeyframes; ++k) {
      if (map_.FindKeyframe({k}) == nullptr) gone.push_back(k);
    }
    return gone;
  }

  MappingContext context_;
  Map map_;
  int next_feature_ = 0;
};

TEST_F(Culling, TheFirstAndTheNewestStay) {
  See(100, All());
  EXPECT_EQ(Gone(), (std::vector{2, 3, 4, 5, 6, 7, 8, 9, 10}));
}

TEST_F(Culling, OfTwoThatAreRedundantToEachOtherTheOlderStays) {
  See(100, All());
  See(30, {9, 10, 19, 20});
  EXPECT_EQ(Gone(), (std::vector{2, 3, 4, 5, 6, 7, 8, 10}));
}

TEST_F(Culling, WhatThreeSeeHoldsThem) {
  See(100, All());
  See(20, {8, 9, 10});
  EXPECT_EQ(Gone(), (std::vector{2, 3, 4, 5, 6, 7}));
}

TEST_F(Culling, WhatHardlyAnybodyFindsAgainHoldsNoKeyframe) {
  See(100, All());
  See(60, {9, 10});
  See(60, {8});
  EXPECT_EQ(Gone(), (std::vector{2, 3, 4, 5, 6, 7, 8, 9, 10}));
  EXPECT_EQ(map_.num_landmarks(), 100u) << "what nobody sees any more goes too";
}

TEST_F(Culling, WhereABlindSpanBeginsAndEndsKeyframesStay) {
  See(100, {1, 2, 3, 4, 5});                                           // before the span
  See(100, {6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20});  // after it
  See(5, {2, 3, 4, 5, 10});
  EXPECT_EQ(Gone(), (std::vector{3, 4, 7, 8, 9, 10}));
  EXPECT_TRUE(map_.FindKeyframe({6})->frame.dr);
  EXPECT_EQ(map_.FindKeyframe({5})->frame.previous.value, 2);
}

}  // namespace
}  // namespace gw::backend

#include "backend/core/place/place_index.h"

#include <gtest/gtest.h>

#include "common/core/random.h"

namespace gw::backend {
namespace {

constexpr int kFeatures = 200;

// Place `place` seen for the `visit`-th time: its own descriptors with `flips` bits wrong in each.
std::vector<Descriptor> Sight(uint64_t place, uint64_t visit, int flips) {
  std::vector<Descriptor> out(kFeatures);
  for (int i = 0; i < kFeatures; ++i) {
    CounterRng point(1, place, static_cast<uint64_t>(i));
    CounterRng noise(2 + visit, place, static_cast<uint64_t>(i));
    for (uint64_t& word : out[i]) word = point.NextU64();
    for (int flip = 0; flip < flips; ++flip) {
      const uint32_t bit = noise.Below(256);
      out[i][bit / 64] ^= uint64_t{1} << (bit % 64);
    }
  }
  return out;
}

PlaceIndex IndexOf(int places) {
  PlaceIndex index;
  for (int p = 1; p <= places; ++p) index.Insert(Place{{p}, Sight(static_cast<uint64_t>(p), 0, 0)});
  return index;
}

TEST(PlaceIndex, FindsThePlaceAgainThroughNoise) {
  const PlaceIndex index = IndexOf(50);
  for (int p = 1; p <= 50; ++p) {
    const auto found = index.Query(Sight(static_cast<uint64_t>(p), 1, 20));
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found.front().keyframe.value, p);
    EXPECT_GT(found.front().score, 0.8);
    EXPECT_GT(found.front().num_matches, kFeatures * 8 / 10);
    for (size_t i = 1; i < found.size(); ++i) EXPECT_LT(found[i].score, 0.05);
  }
}

// Features go through the index in steps, several at a time: none is left out, however few.
TEST(PlaceIndex, EveryFeatureOfAShortQueryIsAnswered) {
  const PlaceIndex index = IndexOf(20);
  for (int n = 1; n <= 6; ++n) {
    std::vector<Descriptor> query = Sight(7, 1, 2);
    query.resize(static_cast<size_t>(n));
    const auto found = index.Query(query);
    ASSERT_EQ(found.size(), 1u) << n;
    EXPECT_EQ(found[0].keyframe.value, 7);
    EXPECT_EQ(found[0].num_matches, n);
  }
}

TEST(PlaceIndex, AnUnknownPlaceScoresNothing) {
  const PlaceIndex index = IndexOf(50);
  for (const PlaceScore& s : index.Query(Sight(99, 0, 0))) EXPECT_LT(s.score, 0.05);
}

TEST(PlaceIndex, WhatEveryPlaceShowsCountsLittle) {
  // All places share a poster: half of their features.
  PlaceIndex index;
  const auto poster = Sight(1000, 0, 0);
  for (int p = 1; p <= 50; ++p) {
    auto sight = Sight(static_cast<uint64_t>(p), 0, 0);
    std::copy(poster.begin(), poster.begin() + kFeatures / 2, sight.begin());
    index.Insert(Place{{p}, sight});
  }
  auto query = Sight(7, 1, 10);
  std::copy(poster.begin(), poster.begin() + kFeatures / 2, query.begin());
  const auto found = index.Query(query);
  ASSERT_GT(found.size(), 1u);
  EXPECT_EQ(found[0].keyframe.value, 7);
  EXPECT_GT(found[0].score, 10 * found[1].score);
  EXPECT_GE(found[1].num_matches, kFeatures / 2);
}

TEST(PlaceIndex, ErasedKeyframesAreGoneAndTheRestStays) {
  PlaceIndex index = IndexOf(20);
  for (int p = 1; p <= 20; p += 2) index.Erase({p});
  index.Erase({12345});
  EXPECT_EQ(index.size(), 10u);
  EXPECT_TRUE(index.Query(Sight(7, 1, 5)).empty() ||
              index.Query(Sight(7, 1, 5)).front().score < 0.05);
  EXPECT_EQ(index.Query(Sight(8, 1, 5)).front().keyframe.value, 8);
  index.Insert(Place{{21}, Sight(21, 0, 0)});  // into a freed slot
  EXPECT_EQ(index.Query(Sight(21, 1, 5)).front().keyframe.value, 21);
  EXPECT_EQ(index.Query(Sight(20, 1, 5)).front().keyframe.value, 20);
}

TEST(PlaceIndex, TheAnswerDoesNotDependOnTheHistory) {
  PlaceIndex grown = IndexOf(30);
  for (int p = 1; p <= 10; ++p) grown.Erase({p});
  for (int p = 10; p >= 1; --p) grown.Insert(Place{{p}, Sight(static_cast<uint64_t>(p), 0, 0)});
  std::vector<std::vector<Descriptor>> sights;
  for (uint64_t p = 1; p <= 30; ++p) sights.push_back(Sight(p, 0, 0));
  std::vector<Place> places;
  for (int p = 1; p <= 30; ++p) places.push_back({{p}, sights[static_cast<size_t>(p - 1)]});
  PlaceIndex fresh;
  fresh.Insert(places);
  EXPECT_EQ(fresh.size(), 30u);
  const auto a = grown.Query(Sight(5, 1, 20));
  const auto b = fresh.Query(Sight(5, 1, 20));
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].keyframe, b[i].keyframe);
    EXPECT_EQ(a[i].score, b[i].score);
  }
}

TEST(PlaceIndex, EmptyQueriesAndEmptyIndicesAreAnswered) {
  PlaceIndex index;
  EXPECT_TRUE(index.Query(Sight(1, 0, 0)).empty());
  index.Insert(Place{{1}, {}});
  EXPECT_TRUE(index.Query({}).empty());
  EXPECT_TRUE(index.Query(Sight(1, 0, 0)).empty());
}

}  // namespace
}  // namespace gw::backend

#include "common/vision/nearest_two.h"

#include <gtest/gtest.h>

namespace gw {
namespace {

struct Point {
  Descriptor descriptor{};
};

// A point whose descriptor has this many bits set: its distance to the descriptor of zeros.
Point WithBits(int bits) {
  Point out;
  for (int i = 0; i < bits; ++i) out.descriptor[i / 64] |= uint64_t{1} << (i % 64);
  return out;
}

NearestTwo Nearest(const std::vector<Point>& points) {
  std::vector<const Point*> pointers;
  for (const Point& point : points) pointers.push_back(&point);
  return FindNearestTwo(Descriptor{}, pointers);
}

TEST(NearestTwo, AreFoundInAnyOrder) {
  for (const auto& points : {std::vector{WithBits(90), WithBits(7), WithBits(30)},
                             std::vector{WithBits(30), WithBits(90), WithBits(7)},
                             std::vector{WithBits(7), WithBits(30), WithBits(90)}}) {
    const NearestTwo near = Nearest(points);
    EXPECT_EQ(near.best, 7);
    EXPECT_EQ(near.second, 30);
    EXPECT_EQ(HammingDistance(points[near.index].descriptor, {}), 7);
  }
}

TEST(NearestTwo, OfEquallyNearTheFirst) {
  const NearestTwo near = Nearest({WithBits(9), WithBits(5), WithBits(5)});
  EXPECT_EQ(near.index, 1u);
  EXPECT_EQ(near.best, 5);
  EXPECT_EQ(near.second, 5);
}

TEST(NearestTwo, WithoutASecondItsDistanceIsBeyondAll) {
  EXPECT_EQ(Nearest({WithBits(256)}).best, 256);
  EXPECT_EQ(Nearest({WithBits(256)}).second, 257);
  EXPECT_EQ(Nearest({}).best, 257);
}

}  // namespace
}  // namespace gw

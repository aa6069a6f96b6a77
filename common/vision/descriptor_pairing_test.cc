#include "common/vision/descriptor_pairing.h"

#include <gtest/gtest.h>

namespace gw {
namespace {

struct Point {
  Descriptor descriptor{};
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
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

TEST(PairDescriptors, TakesUnmistakablePairsAndEachLandmarkOnce) {
  RectifiedCamera camera;
  camera.fx = camera.fy = 400;
  const std::vector<Point> points = {WithBits(0), WithBits(100), WithBits(104), WithBits(200)};
  std::vector<const Point*> pointers;
  for (const Point& point : points) pointers.push_back(&point);
  std::vector<Feature> features(5);
  for (Feature& f : features) f.depth = 2;
  features[1].u = 10;  // as near to the first landmark as can be
  features[4].depth = -1;
  const std::vector<Descriptor> descriptors = {WithBits(8).descriptor, WithBits(1).descriptor,
                                               WithBits(102).descriptor,   // between two
                                               WithBits(150).descriptor,   // far from all
                                               WithBits(200).descriptor};  // without depth
  const auto pairs = PairDescriptors(camera, Pyramid(1.2, 8), features, descriptors, pointers);
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].uv.x(), 10);
}

}  // namespace
}  // namespace gw

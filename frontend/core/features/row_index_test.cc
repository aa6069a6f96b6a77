#include "frontend/core/features/row_index.h"

#include <gtest/gtest.h>

namespace gw::frontend {
namespace {

OrbKeypoint At(float u, float v) {
  OrbKeypoint k;
  k.u = u;
  k.v = v;
  return k;
}

// Differs from the descriptor of zeros in so many bits.
Descriptor WithBits(int bits) {
  Descriptor d{};
  for (int i = 0; i < bits; ++i) d[static_cast<size_t>(i / 64)] |= uint64_t{1} << (i % 64);
  return d;
}

TEST(RowIndex, GivesTheKeypointsAroundARow) {
  RowIndex rows(100);
  rows.Fill({At(1, 50), At(2, 10), At(3, 52.4F), At(4, 99.6F), At(5, 48)});
  const auto near = rows.Near(50.2F, 2);
  ASSERT_EQ(near.size(), 3U);
  EXPECT_EQ(near[0].index, 4);
  EXPECT_EQ(near[1].index, 0);
  EXPECT_EQ(near[2].index, 2);
  EXPECT_EQ(rows.Near(99, 5).size(), 1U);
}

class Unmistakable : public testing::Test {
 protected:
  int Partner(const std::vector<OrbKeypoint>& keypoints, const std::vector<int>& bits) const {
    std::vector<Descriptor> descriptors;
    descriptors.reserve(bits.size());
    for (const int b : bits) descriptors.push_back(WithBits(b));
    const ImagePyramid pyramid(320, 240, 2, 1.2, 32);
    const std::vector<OrbKeypoint> left{At(100, 50)};
    const std::vector<Descriptor> wanted{WithBits(0)};
    RowIndex rows(240);
    rows.Fill(keypoints);
    return UnmistakablePartner({pyramid, left, wanted}, 0, {pyramid, keypoints, descriptors}, rows,
                               {.rows = 2, .least_disparity = -5, .most_disparity = 60});
  }
};

TEST_F(Unmistakable, IsTheOneThatLooksMuchMoreAlike) {
  EXPECT_EQ(Partner({At(90, 50), At(80, 51), At(70, 49)}, {60, 20, 26}), 1);
  EXPECT_EQ(Partner({At(90, 50), At(80, 51), At(70, 49)}, {60, 20, 24}), -1);
}

TEST_F(Unmistakable, WhatStandsAloneHasNoRival) {
  EXPECT_EQ(Partner({At(90, 50)}, {50}), 0);
  EXPECT_EQ(Partner({At(90, 50)}, {51}), -1);
}

TEST_F(Unmistakable, LiesInTheWindow) {
  EXPECT_EQ(Partner({At(90, 53)}, {0}), -1);
  EXPECT_EQ(Partner({At(106, 50)}, {0}), -1);
  EXPECT_EQ(Partner({At(39, 50)}, {0}), -1);
  OrbKeypoint coarse = At(90, 50);
  coarse.level = 2;
  EXPECT_EQ(Partner({coarse}, {0}), -1);
}

}  // namespace
}  // namespace gw::frontend

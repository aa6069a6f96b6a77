#include <gtest/gtest.h>

#include <numeric>

#include "drivers/camera/core/depth_pairer.h"
#include "drivers/camera/core/metadata_joiner.h"

namespace gw::camera {
namespace {

RawFrame Image(uint32_t sequence, int64_t arrival_us = 0) {
  RawFrame frame;
  frame.sequence = sequence;
  frame.arrival = {arrival_us};
  return frame;
}
FrameMetadata At(uint32_t pts_us) {
  FrameMetadata metadata;
  metadata.pts_us = pts_us;
  return metadata;
}
RawFrame Stamped(uint32_t sequence, uint32_t pts_us) {
  RawFrame frame = Image(sequence, sequence);
  frame.metadata = At(pts_us);
  return frame;
}

TEST(MetadataJoiner, WhicheverComesFirst) {
  MetadataJoiner joiner(true);
  EXPECT_TRUE(joiner.AddImage(Image(4)).empty());
  auto out = joiner.AddMetadata(4, At(400));
  ASSERT_EQ(out.size(), 1U);
  EXPECT_EQ(out[0].metadata->pts_us, 400U);
  EXPECT_TRUE(joiner.AddMetadata(5, At(500)).empty());
  out = joiner.AddImage(Image(5));
  ASSERT_EQ(out.size(), 1U);
  EXPECT_EQ(out[0].metadata->pts_us, 500U);
}

TEST(MetadataJoiner, MissingMetadataHoldAnImageUntilTheNextAtMost) {
  MetadataJoiner joiner(true);
  EXPECT_TRUE(joiner.AddImage(Image(1)).empty());
  auto out = joiner.AddImage(Image(2));
  ASSERT_EQ(out.size(), 1U);
  EXPECT_EQ(out[0].sequence, 1U);
  EXPECT_FALSE(out[0].metadata);
  out = joiner.AddMetadata(3, At(300));  // frame 2 is overtaken
  ASSERT_EQ(out.size(), 1U);
  EXPECT_EQ(out[0].sequence, 2U);
  EXPECT_EQ(joiner.AddImage(Image(3))[0].metadata->pts_us, 300U);
  EXPECT_EQ(joiner.without_metadata(), 2);
}

TEST(MetadataJoiner, LostImagesLeaveNothingBehind) {
  MetadataJoiner joiner(true);
  for (uint32_t i = 0; i < 100; ++i) EXPECT_TRUE(joiner.AddMetadata(i, At(i)).empty());
  const auto out = joiner.AddImage(Image(99));
  ASSERT_EQ(out.size(), 1U);
  EXPECT_EQ(out[0].metadata->pts_us, 99U);
}

TEST(MetadataJoiner, SequenceWraps) {
  MetadataJoiner joiner(true);
  EXPECT_TRUE(joiner.AddMetadata(UINT32_MAX, At(1)).empty());
  EXPECT_TRUE(joiner.AddMetadata(0, At(2)).empty());
  EXPECT_EQ(joiner.AddImage(Image(0))[0].metadata->pts_us, 2U);
}

TEST(MetadataJoiner, WithoutMetadataNodeNothingWaits) {
  MetadataJoiner joiner(false);
  EXPECT_EQ(joiner.AddImage(Image(1)).size(), 1U);
  EXPECT_EQ(joiner.without_metadata(), 0);
}

TEST(DepthPairer, ByDeviceTimeAcrossItsWrap) {
  DepthPairer pairer(Milliseconds(33));
  EXPECT_FALSE(pairer.AddDepth(Stamped(10, UINT32_MAX)));
  const auto pair = pairer.AddImage(Stamped(20, 3));
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->image.sequence, 20U);
  EXPECT_EQ(pair->depth.sequence, 10U);
}

TEST(DepthPairer, LostHalvesAreDroppedAndCounted) {
  DepthPairer pairer(Milliseconds(33));
  int pairs = 0;
  for (uint32_t i = 0; i < 300; ++i) {
    if (i % 7 != 3) pairs += pairer.AddImage(Stamped(i, 33'333 * i)).has_value() ? 1 : 0;
    if (i % 11 == 5) continue;
    const auto pair = pairer.AddDepth(Stamped(i, 33'333 * i));
    if (!pair) continue;
    EXPECT_EQ(pair->image.sequence, pair->depth.sequence);
    ++pairs;
  }
  // 43 images and 27 depth images were lost, 4 of them together.
  EXPECT_EQ(pairs, 300 - 43 - 27 + 4);
  EXPECT_EQ(pairer.unpaired(), 43 + 27 - 2 * 4);
}

TEST(DepthPairer, WithoutMetadataArrivalsDecide) {
  DepthPairer pairer(Milliseconds(33));
  EXPECT_FALSE(pairer.AddImage(Image(1, 100'000)));
  EXPECT_FALSE(pairer.AddDepth(Image(1, 133'000)));
  EXPECT_TRUE(pairer.AddImage(Image(2, 131'000)));
  EXPECT_EQ(pairer.unpaired(), 1);
}

TEST(DepthPairer, OneStreamAloneDoesNotFillTheMemory) {
  DepthPairer pairer(Milliseconds(33));
  for (uint32_t i = 0; i < 100; ++i) EXPECT_FALSE(pairer.AddImage(Stamped(i, 33'333 * i)));
  EXPECT_EQ(pairer.unpaired(), 96);
}

}  // namespace
}  // namespace gw::camera

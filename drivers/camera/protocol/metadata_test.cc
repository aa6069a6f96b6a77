#include "drivers/camera/protocol/metadata.h"

#include <gtest/gtest.h>

#include "common/core/random.h"
#include "test/emulators/camera/camera_peer.h"

namespace gw::camera {
namespace {

FrameMetadata Full() {
  FrameMetadata m;
  m.host_ns = 1'234'567'890'123;
  m.pts_us = 4'294'967'290U;
  m.frame_counter = 77;
  m.to_mid_exposure_us = 4250;
  m.exposure_us = 8500;
  m.gain = 16;
  m.laser_power_mw = 150;
  m.emitter_on = false;
  return m;
}

TEST(Metadata, EveryFieldOfTheD4xxBlocks) {
  const auto parsed = ParseMetadata(EncodeMetadata(Full(), true));
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->host_ns, 1'234'567'890'123);
  EXPECT_EQ(parsed->pts_us, 4'294'967'290U);
  EXPECT_EQ(parsed->frame_counter, 77U);
  EXPECT_EQ(parsed->to_mid_exposure_us, 4250U);
  EXPECT_EQ(parsed->exposure_us, 8500U);
  EXPECT_EQ(parsed->gain, 16U);
  EXPECT_EQ(parsed->laser_power_mw, 150U);
  EXPECT_EQ(parsed->emitter_on, false);
}

// The kernel of Debian 12 gives 22 bytes, of which the length byte claims 232.
TEST(Metadata, HeaderAloneStillHasTheDeviceTime) {
  const auto bytes = EncodeMetadata(Full(), false);
  ASSERT_EQ(bytes.size(), 22U);
  const auto parsed = ParseMetadata(bytes);
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->pts_us, 4'294'967'290U);
  EXPECT_FALSE(parsed->exposure_us);
  EXPECT_FALSE(parsed->emitter_on);
}

TEST(Metadata, FieldsWithoutTheirFlagAreAbsent) {
  FrameMetadata m = Full();
  m.to_mid_exposure_us.reset();
  m.emitter_on.reset();
  const auto parsed = ParseMetadata(EncodeMetadata(m, true));
  ASSERT_TRUE(parsed);
  EXPECT_FALSE(parsed->to_mid_exposure_us);
  EXPECT_FALSE(parsed->emitter_on);
  EXPECT_EQ(parsed->exposure_us, 8500U);
}

TEST(Metadata, NoTimeStampWithoutItsFlag) {
  FrameMetadata m;
  m.pts_us.reset();
  EXPECT_FALSE(ParseMetadata(EncodeMetadata(m, true))->pts_us);
}

TEST(Metadata, BlockBeyondTheEndAndShortBuffersAreRefused) {
  auto bytes = EncodeMetadata(Full(), true);
  bytes[22 + 4] = 250;  // size of the first block
  EXPECT_EQ(ParseMetadata(bytes).error().code, ErrorCode::kBadData);
  bytes[22 + 4] = 0;  // a block of size 0 would never end
  EXPECT_FALSE(ParseMetadata(bytes));
  EXPECT_FALSE(ParseMetadata({}));
  EXPECT_FALSE(ParseMetadata(std::vector<uint8_t>(11)));
}

TEST(Metadata, AnyBytesAreSafe) {
  const auto valid = EncodeMetadata(Full(), true);
  int accepted = 0;
  for (uint64_t seed = 0; seed < 200'000; ++seed) {
    CounterRng rng(seed, 1, 0);
    auto bytes = valid;
    bytes.resize(rng.Below(static_cast<uint32_t>(valid.size()) + 1));
    for (int i = 0; i < 3 && !bytes.empty(); ++i) {
      bytes[rng.Below(static_cast<uint32_t>(bytes.size()))] = static_cast<uint8_t>(rng.Below(256));
    }
    accepted += ParseMetadata(bytes).ok() ? 1 : 0;
  }
  EXPECT_GT(accepted, 0);
}

}  // namespace
}  // namespace gw::camera

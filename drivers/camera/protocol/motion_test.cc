#include <gtest/gtest.h>

#include <numbers>

#include "drivers/camera/protocol/iio_buffer.h"
#include "drivers/camera/protocol/motion_units.h"

namespace gw::camera {
namespace {

using Bytes = std::vector<uint8_t>;

Result<IioLayout> Layout(const std::vector<std::array<const char*, 3>>& channels) {
  std::vector<IioChannel> parsed;
  for (const auto& [name, index, type] : channels) {
    auto channel = ParseIioChannel(name, index, type);
    if (!channel) return channel.error();
    parsed.push_back(*channel);
  }
  return IioLayout::Create(parsed);
}

// The driver hid-sensor-accel-3d offers rows of 3 x s32, padding, s64.
TEST(IioBuffer, RowOfTheMotionModule) {
  const auto layout = Layout({{"in_timestamp", "3", "le:s64/64>>0"},
                              {"in_accel_x", "0", "le:s32/32>>0"},
                              {"in_accel_y", "1", "le:s32/32>>0"},
                              {"in_accel_z", "2", "le:s32/32>>0"}});
  ASSERT_TRUE(layout) << layout.error().message;
  ASSERT_EQ(layout->row_bytes(), 24U);
  Bytes row(24);
  row[0] = 5;
  row[4] = row[5] = row[6] = row[7] = 0xFF;
  row[8] = 1;
  row[9] = 1;
  row[16] = 7;
  row[20] = 1;
  EXPECT_EQ(layout->Decode(row), (std::vector<int64_t>{5, -1, 257, (int64_t{1} << 32) + 7}));
  EXPECT_EQ(layout->Find("in_timestamp"), 3);
  EXPECT_EQ(layout->Find("in_accel_w"), -1);
}

TEST(IioBuffer, EndianShiftWidthAndSign) {
  const auto layout = Layout({{"a", "0", "be:s12/16>>4"}, {"b", "1", "le:u10/16>>2"}});
  ASSERT_TRUE(layout);
  EXPECT_EQ(layout->row_bytes(), 4U);
  EXPECT_EQ(layout->Decode(Bytes{0xFF, 0xE7, 0xFF, 0xFF}), (std::vector<int64_t>{-2, 1023}));
}

TEST(IioBuffer, PaddingIsToTheLargestChannel) {
  const auto layout = Layout({{"t", "0", "le:s64/64>>0"}, {"x", "1", "le:s16/16>>0"}});
  ASSERT_TRUE(layout);
  EXPECT_EQ(layout->row_bytes(), 16U);
}

TEST(IioBuffer, WhatItDoesNotUnderstandIsRefused) {
  for (const char* type : {"", "le:s32/32", "xe:s32/32>>0", "le:f32/32>>0", "le:s33/32>>0",
                           "le:s32/24>>0", "le:s32/32>>1", "le:s0/32>>0", "le:s32/32>>-1"}) {
    EXPECT_FALSE(ParseIioChannel("x", "0", type)) << type;
  }
  EXPECT_FALSE(ParseIioChannel("x", "first", "le:s32/32>>0"));
  EXPECT_FALSE(Layout({{"x", "0", "le:s32/32>>0"}, {"y", "0", "le:s32/32>>0"}}));
  EXPECT_FALSE(Layout({}));
}

TEST(MotionUnits, GyroScaleDependsOnTheFirmware) {
  const double deg = std::numbers::pi / 180;
  // In samples of old firmware the high half is rubbish.
  const Eigen::Vector3d old = GyroFromRaw({0x7000000A, 0xFFFF, 20}, FirmwareVersion{5, 15, 1, 0});
  EXPECT_TRUE(old.isApprox(Eigen::Vector3d(-1.0, -0.1, -2.0) * deg, 1e-12)) << old.transpose();
  const Eigen::Vector3d fine = GyroFromRaw({10'000, -1'000, 20'000}, FirmwareVersion{5, 16, 0, 1});
  EXPECT_TRUE(fine.isApprox(Eigen::Vector3d(-1.0, -0.1, -2.0) * deg, 1e-12)) << fine.transpose();
}

TEST(MotionUnits, SpecificForcePointsUpAtRest) {
  const Eigen::Vector3d a_I = AccelFromRaw({0, -1000, 0});
  EXPECT_TRUE(a_I.isApprox(Eigen::Vector3d(0, -9.80665, 0)));
  EXPECT_TRUE(AccelFromRaw({1000, 0, 1000}).isApprox(Eigen::Vector3d(-9.80665, 0, -9.80665)));
}

TEST(MotionUnits, RatesAreCodes) {
  EXPECT_EQ(SamplingFrequencyCode(63), 1);
  EXPECT_EQ(SamplingFrequencyCode(200), 2);
  EXPECT_EQ(SamplingFrequencyCode(250), 3);
  EXPECT_EQ(SamplingFrequencyCode(400), 4);
  EXPECT_FALSE(SamplingFrequencyCode(50));
}

}  // namespace
}  // namespace gw::camera

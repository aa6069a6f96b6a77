#include <gtest/gtest.h>

#include <algorithm>

#include "common/core/random.h"
#include "drivers/camera/protocol/calibration_table.h"
#include "drivers/camera/protocol/hardware_monitor.h"
#include "drivers/common/bytes.h"
#include "test/emulators/camera/camera_peer.h"

namespace gw::camera {
namespace {

using Bytes = std::vector<uint8_t>;

Bytes Begin(const Bytes& bytes, size_t size) {
  return {bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(size)};
}

TEST(HardwareMonitor, RequestsAsWrittenOnThePage) {
  const Bytes calibration = EncodeRequest(CalibrationRequest(kDepthTableId));
  ASSERT_EQ(calibration.size(), 1024U);
  EXPECT_EQ(Begin(calibration, 12), (Bytes{0x14, 0, 0xAB, 0xCD, 0x15, 0, 0, 0, 0x19, 0, 0, 0}));
  EXPECT_TRUE(std::all_of(calibration.begin() + 12, calibration.end(), [](int b) { return !b; }));
  EXPECT_EQ(Begin(EncodeRequest(VersionRequest()), 12),
            (Bytes{0x14, 0, 0xAB, 0xCD, 0x10, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(HardwareMonitor, AlternatingEmitterIsASequenceOfTwoFrames) {
  const Bytes on = EncodeRequest(AlternatingEmitterRequest(true));
  EXPECT_EQ(ReadU16(on, 0), 20 + 23);
  EXPECT_EQ(ReadU32(on, 4), 0x7BU);
  EXPECT_EQ(ReadU32(on, 8), 23U);
  EXPECT_EQ(Bytes(on.begin() + 24, on.begin() + 29), (Bytes{5, 0x0F, 0, 0, 2}));
  EXPECT_EQ(on[24 + 5 + 5], 0);      // laser of the first item
  EXPECT_EQ(on[24 + 5 + 9 + 5], 1);  // and of the second
  EXPECT_EQ(ReadU32(EncodeRequest(AlternatingEmitterRequest(false)), 8), 0U);
}

TEST(HardwareMonitor, AnswersAreChecked) {
  const Bytes payload{1, 2, 3};
  EXPECT_EQ(*DecodeAnswer(EncodeAnswer(0x15, payload), Opcode::kCalibrationTable), payload);
  EXPECT_FALSE(DecodeAnswer(EncodeAnswer(0x10, payload), Opcode::kCalibrationTable));
  const auto refused = DecodeAnswer(EncodeAnswer(-25, {}), Opcode::kCalibrationTable);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("table is empty"), std::string::npos);
  Bytes too_long = EncodeAnswer(0x15, payload);
  too_long[1021] = 4;
  EXPECT_FALSE(DecodeAnswer(too_long, Opcode::kCalibrationTable));
  EXPECT_FALSE(DecodeAnswer(payload, Opcode::kCalibrationTable));
}

TEST(HardwareMonitor, VersionBlock) {
  const auto version = ParseVersion(EncodeVersion({5, 16, 0, 1}, "a1b2c3d4e5f6"));
  ASSERT_TRUE(version);
  EXPECT_EQ(version->firmware.text(), "5.16.0.1");
  EXPECT_EQ(version->asic_serial, "a1b2c3d4e5f6");
  EXPECT_EQ(version->module_serial, "0123456789ab");
  EXPECT_FALSE(ParseVersion(Bytes(69)));
}

TEST(DepthTable, IntrinsicsAndBaseline) {
  const StoredCalibration stored;
  const auto vga = ParseDepthTable(EncodeDepthTable(stored), 640, 480);
  ASSERT_TRUE(vga) << vga.error().message;
  EXPECT_DOUBLE_EQ(vga->baseline_m, 0.05);
  EXPECT_DOUBLE_EQ(vga->camera.fx, 385);
  EXPECT_DOUBLE_EQ(vga->camera.fy, 385.5);
  EXPECT_DOUBLE_EQ(vga->camera.cx, 320.25);
  EXPECT_DOUBLE_EQ(vga->camera.cy, 239.75);
}

TEST(DepthTable, OtherResolutions) {
  const Bytes table = EncodeDepthTable({});
  // This resolution is not in the table and is scaled from 1920x1080.
  const auto scaled = ParseDepthTable(table, 960, 270);
  ASSERT_TRUE(scaled);
  EXPECT_DOUBLE_EQ(scaled->camera.fx, 962.5 / 2);
  EXPECT_DOUBLE_EQ(scaled->camera.fy, 962.5 / 4);
  EXPECT_DOUBLE_EQ(scaled->camera.cy, 135);
  // This entry is a placeholder.
  const auto placeholder = ParseDepthTable(table, 848, 480);
  ASSERT_TRUE(placeholder);
  EXPECT_DOUBLE_EQ(placeholder->camera.fx, 1272);
  EXPECT_DOUBLE_EQ(placeholder->camera.cx, 424);
  // This mode shows the middle rows of the one before.
  const auto strip = ParseDepthTable(table, 848, 100);
  ASSERT_TRUE(strip);
  EXPECT_DOUBLE_EQ(strip->camera.cy, 50);
}

TEST(DepthTable, NegativeBaselineIsTheOtherSignConvention) {
  StoredCalibration stored;
  stored.baseline_mm = -49.9F;
  EXPECT_NEAR(ParseDepthTable(EncodeDepthTable(stored), 640, 480)->baseline_m, 0.0499, 1e-8);
}

TEST(DepthTable, EveryFlippedBitBehindTheHeaderIsFound) {
  const Bytes valid = EncodeDepthTable({});
  for (size_t bit = 8 * size_t{12}; bit < 8 * valid.size(); ++bit) {
    Bytes bytes = valid;
    bytes[bit / 8] = static_cast<uint8_t>(bytes[bit / 8] ^ (1U << bit % 8));
    ASSERT_FALSE(ParseDepthTable(bytes, 640, 480)) << bit;
  }
}

TEST(DepthTable, ShortTablesAndImpossibleValuesAreRefused) {
  const Bytes valid = EncodeDepthTable({});
  for (size_t size = 0; size < valid.size(); ++size) {
    ASSERT_FALSE(ParseDepthTable(Begin(valid, size), 640, 480));
  }
  EXPECT_FALSE(ParseDepthTable(EncodeDepthTable({.baseline_mm = 0}), 640, 480));
  EXPECT_FALSE(ParseDepthTable(EncodeDepthTable({.vga = {0, 1, 2, 3}}), 640, 480));
}

TEST(Rectified, FoundByResolution) {
  Bytes answer;
  for (const int width : {1280, 640}) {
    AppendU16(static_cast<uint16_t>(width), &answer);
    AppendU16(480, &answer);
    for (const float value : {380.F + static_cast<float>(width), 381.F, 320.F, 240.F}) {
      AppendF32(value, &answer);
    }
  }
  const auto vga = FindRectified(answer, 640, 480);
  ASSERT_TRUE(vga);
  EXPECT_DOUBLE_EQ(vga->fx, 1020);
  EXPECT_FALSE(FindRectified(answer, 640, 360));
  EXPECT_FALSE(FindRectified(Begin(answer, 39), 640, 480));
}

}  // namespace
}  // namespace gw::camera

// Tests with worked byte examples of the Kobuki protocol (drivers/kobuki/README.md), and of what
// the encoders promise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "common/core/random.h"
#include "drivers/kobuki/protocol/base_control.h"
#include "drivers/kobuki/protocol/command.h"
#include "drivers/kobuki/protocol/feedback.h"
#include "drivers/kobuki/protocol/frame.h"
#include "drivers/kobuki/protocol/output_word.h"

namespace gw::kobuki {
namespace {

constexpr double kTrack = 0.23;

std::vector<uint8_t> Hex(const std::string& text) {
  std::vector<uint8_t> out;
  for (size_t at = 0; at < text.size(); at += 3) {
    out.push_back(static_cast<uint8_t>(std::stoi(text.substr(at, 2), nullptr, 16)));
  }
  return out;
}

// Parses bytes that are exactly one frame.
Feedback DecodeOne(const std::vector<uint8_t>& bytes) {
  FrameParser parser;
  const auto frames = parser.Push(bytes);
  EXPECT_EQ(frames.size(), 1u);
  EXPECT_FALSE(parser.has_partial());
  EXPECT_EQ(parser.counters().skipped_bytes, 0);
  return frames.empty() ? Feedback() : DecodeFeedback(frames[0].payload);
}

TEST(KobukiFeedback, SyntheticFrameDecodesAsStated) {
  const Feedback f = DecodeOne(
      Hex("AA 55 4D 01 0F 39 30 02 00 00 E8 03 DC FF 28 DA 01 06 A3 00 03 03 02 0A 00 04 07 "
          "2E FB FA 00 00 00 00 05 06 A4 06 72 06 B8 06 06 02 0C 0B 0D 0E 2A 06 0A 00 EC FF "
          "1E 00 0B 00 EB FF 1F 00 10 10 05 00 FF 0F 00 08 00 00 00 01 00 00 00 00 00 00 4E"));
  Feedback e;
  e.basic = BasicData{.timestamp_ms = 12345,
                      .bumper = kCentreBit,
                      .left_encoder = 1000,
                      .right_encoder = 65500,
                      .left_pwm = 40,
                      .right_pwm = -38,
                      .buttons = 0x01,
                      .charger = 6,
                      .battery_dv = 163};
  e.docking_ir = DockingIr{0x02, 0x0A, 0};
  e.inertial = Inertial{-1234, 250};
  e.cliff = CliffAdc{1700, 1650, 1720};
  e.current = MotorCurrent{12, 11};
  e.raw_gyro = RawGyro{0x2A, {{10, -20, 30}, {11, -21, 31}}};
  e.gp_input = GpInput{0x5, {4095, 2048, 0, 256}};
  EXPECT_EQ(f, e);
}

TEST(KobukiFeedback, FrameOfARealRobotDecodesAsStated) {
  const Feedback f = DecodeOne(
      Hex("AA 55 4D 01 0F A8 0B 00 00 00 FC FF EF F3 00 00 00 00 9D 00 03 03 00 00 00 04 07 9B E7 "
          "00 00 00 00 00 05 06 89 06 AD 07 49 06 06 02 00 00 0D 0E EE 06 2A 00 92 FF BC FF 23 00 "
          "98 FF B9 FF 10 10 00 00 FF 0F FF 0F FF 0F FF 0F F0 0F 00 00 00 00 62"));
  Feedback e;
  e.basic = BasicData{
      .timestamp_ms = 2984, .left_encoder = 65532, .right_encoder = 62447, .battery_dv = 157};
  e.docking_ir = DockingIr{};
  e.inertial = Inertial{-6245, 0};
  e.cliff = CliffAdc{1673, 1965, 1609};
  e.current = MotorCurrent{};
  e.raw_gyro = RawGyro{238, {{42, -110, -68}, {35, -104, -71}}};
  e.gp_input = GpInput{0, {4095, 4095, 4095, 4095}};
  EXPECT_EQ(f, e);
}

TEST(KobukiFeedback, VersionsArriveAsTheirOwnFrame) {
  const Feedback f =
      DecodeOne(Hex("AA 55 1A 0A 04 04 00 01 00 0B 04 00 02 01 00 13 0C 30 FF D2 05 4D 58 36 32 "
                    "22 61 25 51 3C"));
  Feedback e;
  e.hardware = Version{1, 0, 4};
  e.firmware = Version{1, 2, 0};
  e.udid = Udid{{97713968, 842422349, 1361404194}};
  EXPECT_EQ(f, e);
}

TEST(KobukiFeedback, HeaderBytesInsideAPayloadAreData) {
  FrameParser parser;
  EXPECT_TRUE(
      parser.Push(Hex("AA 55 11 01 0F AA 55 00 00 00 AA 55 55 AA 00 00 00 00 A0 00 40")).empty())
      << "the second header inside could begin a frame of 85 bytes";
  const auto frames = parser.AbandonPartial();
  ASSERT_EQ(frames.size(), 1);
  const Feedback f = DecodeFeedback(frames[0].payload);
  Feedback e;
  e.basic = BasicData{
      .timestamp_ms = 0x55AA, .left_encoder = 0x55AA, .right_encoder = 0xAA55, .battery_dv = 160};
  EXPECT_EQ(f, e);
}

TEST(KobukiFeedback, ControllerInfoHoldsTheDefaults) {
  const Feedback f = DecodeFeedback(Hex("15 0D 00 A0 86 01 00 64 00 00 00 D0 07 00 00"));
  EXPECT_EQ(f.controller, (ControllerInfo{0, 100000, 100, 2000}));
}

TEST(KobukiFeedback, AncientFirmwareSendsShortVersions) {
  const auto firmware = [](uint16_t number) {
    return DecodeFeedback(std::vector<uint8_t>{0x0B, 2, static_cast<uint8_t>(number & 0xFF),
                                               static_cast<uint8_t>(number >> 8)})
        .firmware;
  };
  EXPECT_EQ(firmware(123), (Version{1, 0, 0}));
  EXPECT_EQ(firmware(110), (Version{1, 1, 0}));
  EXPECT_EQ(firmware(10100), (Version{1, 1, 0}));
  EXPECT_EQ(firmware(111), (Version{1, 1, 1}));
  EXPECT_EQ(firmware(10101), (Version{1, 1, 1}));
  EXPECT_EQ(DecodeFeedback(Hex("0A 02 68 00")).hardware, (Version{1, 0, 4}));
}

TEST(KobukiFeedback, UnknownAndMisSizedSubPayloadsAreSkippedByTheirLength) {
  // The frame holds a reserved id, a docking IR of two bytes, a gyro whose count disagrees, then a
  // good current.
  const Feedback f =
      DecodeFeedback(Hex("02 01 00 03 02 00 00 0D 08 00 06 00 00 00 00 00 00 06 02 01 02"));
  EXPECT_EQ(f.unknown, 1);
  EXPECT_EQ(f.bad_length, 2);
  EXPECT_FALSE(f.docking_ir || f.raw_gyro);
  EXPECT_EQ(f.current, (MotorCurrent{1, 2}));
}

TEST(KobukiCommand, WorkedExamplesOfBaseControl) {
  const struct {
    double v, w;
    int16_t speed, radius;
    const char* bytes;
  } cases[] = {
      {0.2, 0, 200, 0, "AA 55 06 01 04 C8 00 00 00 CB"},
      {0, 0.5, 57, 1, "AA 55 06 01 04 39 00 01 00 3B"},
      {0, -0.5, -57, 1, "AA 55 06 01 04 C7 FF 01 00 3A"},
      {0.2, 0.5, 257, 400, "AA 55 06 01 04 01 01 90 01 92"},
      {0.2, -0.5, 257, -400, "AA 55 06 01 04 01 01 70 FE 8D"},
      {-0.2, 0, -200, 0, "AA 55 06 01 04 38 FF 00 00 C4"},
      {0.7, 0, 700, 0, "AA 55 06 01 04 BC 02 00 00 BD"},
      {0, 0, 0, 0, "AA 55 06 01 04 00 00 00 00 03"},
  };
  for (const auto& c : cases) {
    const BaseControl control = MakeBaseControl({c.v, c.w}, kTrack);
    EXPECT_EQ(control, (BaseControl{c.speed, c.radius})) << c.bytes;
    EXPECT_EQ(CommandFrame().Drive(control).Encode(), Hex(c.bytes));
  }
}

TEST(KobukiCommand, OtherWorkedExamples) {
  EXPECT_EQ(CommandFrame().RequestExtra(kRequestIdentity).Encode(), Hex("AA 55 04 09 02 0B 00 04"));
  EXPECT_EQ(CommandFrame().GetGains().Encode(), Hex("AA 55 03 0E 01 00 0C"));
  EXPECT_EQ(CommandFrame().SetGains({}).Encode(),
            Hex("AA 55 0F 0D 0D 00 A0 86 01 00 64 00 00 00 D0 07 00 00 9B"));
  OutputWord output;
  output.Set(Led::kLed1, LedColour::kGreen);
  EXPECT_EQ(CommandFrame().Output(output.value()).Encode(), Hex("AA 55 04 0C 02 F0 02 F8"));
  EXPECT_EQ(CommandFrame().Play(SoundSequence::kOn).Encode(), Hex("AA 55 03 04 01 00 06"));
  EXPECT_EQ(CommandFrame().Sound(SoundNote(440), 200).Encode(), Hex("AA 55 05 03 03 3A 03 C8 F4"));
  EXPECT_EQ(CommandFrame().Drive({200, 0}).RequestExtra(kRequestIdentity).Encode(),
            Hex("AA 55 0A 01 04 C8 00 00 00 09 02 0B 00 C7"));
}

TEST(KobukiCommand, LedsNeverTouchTheSupplies) {
  OutputWord output;
  EXPECT_EQ(output.value(), 0x00F0);
  output.Set(Led::kLed2, LedColour::kOrange);
  output.Set(Led::kLed1, LedColour::kRed);
  EXPECT_EQ(output.value(), 0x0DF0);
  output.Set(Led::kLed2, LedColour::kOff);
  output.Set(Supply::k12V1A5, false);
  output.SetDigital(2, true);
  EXPECT_EQ(output.value(), 0x0174);
}

TEST(KobukiBaseControl, FirmwareDrivesWhatWasAskedWithinTheResolutionOfTheWire) {
  for (uint64_t i = 0; i < 20000; ++i) {
    CounterRng rng(1, 1, i);
    const Twist asked{rng.Uniform(-0.7, 0.7), rng.Uniform(-3.1, 3.1) * std::pow(rng.Uniform(), 4)};
    const Twist driven = ToTwist(MakeBaseControl(asked, kTrack), kTrack);
    // Half a millimetre per second of the outer wheel and half a millimetre of the radius; wide
    // turns besides are quantised between straight and the widest radius.
    const double widest = 32.767;
    const double wide =
        std::abs(asked.w_rad_s) * widest < std::abs(asked.v_m_s) ? 0.5 * 0.7 / widest : 0;
    EXPECT_NEAR(driven.w_rad_s, asked.w_rad_s, 0.0005 / 0.115 + 1e-4 + wide) << i;
    EXPECT_NEAR(driven.v_m_s, asked.v_m_s, 0.0005 + 0.002 * std::abs(asked.w_rad_s) + 2e-4) << i;
  }
}

TEST(KobukiBaseControl, TinyRadiusKeepsTheTurnRate) {
  for (const double v : {0.0011, 0.0015, 0.0019, -0.0011, -0.0019}) {
    for (const double w : {1.0, -1.0}) {
      const BaseControl control = MakeBaseControl({v, w}, kTrack);
      EXPECT_EQ(std::abs(control.radius_mm), 2);
      EXPECT_NEAR(ToTwist(control, kTrack).w_rad_s, w, 0.005);
    }
  }
}

TEST(KobukiBaseControl, NonsenseIsAStopAndLargeValuesSaturate) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const Twist t : {Twist{nan, 0}, Twist{0, nan}, Twist{inf, 1}, Twist{0, -inf}}) {
    EXPECT_EQ(MakeBaseControl(t, kTrack), BaseControl{});
  }
  EXPECT_EQ(MakeBaseControl({1e9, 0}, kTrack).speed_mm_s, 32767);
  EXPECT_EQ(MakeBaseControl({-1e9, 0}, kTrack).speed_mm_s, -32767);
  EXPECT_EQ(MakeBaseControl({0, 1e9}, kTrack), (BaseControl{32767, 1}));
}

TEST(KobukiCommand, NotesOutOfRangeSaturate) {
  EXPECT_EQ(SoundNote(440), 826);
  EXPECT_EQ(SoundNote(0), 0);
  EXPECT_EQ(SoundNote(-1), 0);
  EXPECT_EQ(SoundNote(1e-3), 65535);
}

}  // namespace
}  // namespace gw::kobuki

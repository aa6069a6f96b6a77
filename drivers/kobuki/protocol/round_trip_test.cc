// Tests of the driver's half of the protocol against the robot's half, and against damage.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/core/random.h"
#include "drivers/kobuki/protocol/command.h"
#include "drivers/kobuki/protocol/feedback.h"
#include "drivers/kobuki/protocol/frame.h"
#include "test/emulators/kobuki/wire_peer.h"

namespace gw::kobuki {
namespace {

uint8_t Byte(CounterRng& rng) {
  return static_cast<uint8_t>(rng.Below(256));
}
uint16_t Word(CounterRng& rng) {
  // Now and then the data are header bytes.
  return rng.Below(8) == 0 ? 0x55AA : static_cast<uint16_t>(rng.Below(65536));
}
int16_t Signed(CounterRng& rng) {
  return static_cast<int16_t>(Word(rng));
}
uint32_t Long(CounterRng& rng) {
  return static_cast<uint32_t>(rng.NextU64());
}

// The frames in bytes behind which nothing comes.
std::vector<Frame> ParseAll(const std::vector<uint8_t>& bytes, FrameParser* parser) {
  auto frames = parser->Push(bytes);
  for (Frame& frame : parser->AbandonPartial()) frames.push_back(std::move(frame));
  return frames;
}
std::vector<Frame> ParseAll(const std::vector<uint8_t>& bytes) {
  FrameParser parser;
  return ParseAll(bytes, &parser);
}

Feedback RandomFeedback(CounterRng& rng, bool complete) {
  const auto present = [&] { return complete || rng.Below(3) != 0; };
  Feedback f;
  if (present()) {
    f.basic = BasicData{.timestamp_ms = Word(rng),
                        .bumper = Byte(rng),
                        .wheel_drop = Byte(rng),
                        .cliff = Byte(rng),
                        .left_encoder = Word(rng),
                        .right_encoder = Word(rng),
                        .left_pwm = static_cast<int8_t>(Byte(rng)),
                        .right_pwm = static_cast<int8_t>(Byte(rng)),
                        .buttons = Byte(rng),
                        .charger = Byte(rng),
                        .battery_dv = Byte(rng),
                        .over_current = Byte(rng)};
  }
  if (present()) f.docking_ir = DockingIr{Byte(rng), Byte(rng), Byte(rng)};
  if (present()) f.inertial = Inertial{Signed(rng), Signed(rng)};
  if (present()) f.cliff = CliffAdc{Word(rng), Word(rng), Word(rng)};
  if (present()) f.current = MotorCurrent{Byte(rng), Byte(rng)};
  if (present()) {
    f.raw_gyro = RawGyro{Byte(rng), {}};
    const uint32_t n = complete ? 2 + rng.Below(2) : 1 + rng.Below(kMaxGyroSamples);
    for (uint32_t i = 0; i < n; ++i) {
      f.raw_gyro->samples.push_back({Signed(rng), Signed(rng), Signed(rng)});
    }
  }
  if (present()) f.gp_input = GpInput{Word(rng), {Word(rng), Word(rng), Word(rng), Word(rng)}};
  if (complete) return f;  // what every frame of a robot holds
  const auto version = [&] {
    return Version{static_cast<int>(rng.Below(10)), static_cast<int>(rng.Below(10)),
                   static_cast<int>(rng.Below(10))};
  };
  if (present()) f.hardware = version();
  if (present()) f.firmware = version();
  if (present()) f.udid = Udid{{Long(rng), Long(rng), Long(rng)}};
  if (present() || !f.basic) f.controller = ControllerInfo{Byte(rng), Long(rng), Long(rng), 7};
  return f;
}

TEST(KobukiRoundTrip, EveryFeedbackSurvivesEncodingAndDecoding) {
  for (uint64_t i = 0; i < 5000; ++i) {
    CounterRng rng(2, 1, i);
    const Feedback sent = RandomFeedback(rng, false);
    const auto frames = ParseAll(EncodeFrame(EncodeFeedback(sent)));
    ASSERT_EQ(frames.size(), 1u) << i;
    EXPECT_EQ(DecodeFeedback(frames[0].payload), sent) << i;
  }
}

TEST(KobukiRoundTrip, EveryCommandReachesTheRobot) {
  for (uint64_t i = 0; i < 5000; ++i) {
    CounterRng rng(2, 2, i);
    CommandFrame frame;
    Commands sent;
    if (rng.Below(2) == 0) {
      sent.drive = BaseControl{Signed(rng), Signed(rng)};
      frame.Drive(*sent.drive);
    }
    if (rng.Below(2) == 0) {
      sent.sound = SoundCommand{Word(rng), Byte(rng)};
      frame.Sound(sent.sound->note, sent.sound->duration_ms);
    }
    if (rng.Below(2) == 0) {
      sent.sound_sequence = static_cast<uint8_t>(rng.Below(7));
      frame.Play(static_cast<SoundSequence>(*sent.sound_sequence));
    }
    if (rng.Below(2) == 0) {
      sent.request = Word(rng);
      frame.RequestExtra(*sent.request);
    }
    if (rng.Below(2) == 0) {
      const Gains gains{rng.Below(2) == 0, Long(rng), Long(rng), Long(rng)};
      sent.set_gains = ControllerInfo{static_cast<uint8_t>(gains.user ? 1 : 0), gains.p_milli,
                                      gains.i_milli, gains.d_milli};
      frame.SetGains(gains);
    }
    if (rng.Below(2) == 0) {
      sent.get_gains = true;
      frame.GetGains();
    }
    if (rng.Below(2) == 0 || frame.empty()) {
      sent.output = Word(rng);
      frame.Output(*sent.output);
    }
    const auto frames = ParseAll(frame.Encode());
    ASSERT_EQ(frames.size(), 1u) << i;
    EXPECT_EQ(DecodeCommands(frames[0].payload), sent) << i;
  }
}

// A stream of true frames with damage in and between them.
struct Stream {
  struct Truth {
    size_t begin = 0;
    std::vector<uint8_t> bytes;
  };
  std::vector<uint8_t> bytes;
  std::vector<Truth> intact;
};

Stream DamagedStream(CounterRng& rng, int num_frames) {
  Stream out;
  for (int i = 0; i < num_frames; ++i) {
    std::vector<uint8_t> frame = EncodeFrame(EncodeFeedback(RandomFeedback(rng, true)));
    switch (rng.Below(12)) {
      case 0: {  // noise on the line
        const uint32_t n = rng.Below(300);
        for (uint32_t k = 0; k < n; ++k) out.bytes.push_back(Byte(rng));
        break;
      }
      case 1: {  // the start of a frame that never ends
        out.bytes.insert(out.bytes.end(),
                         {kHeader0, kHeader1, static_cast<uint8_t>(rng.Below(256))});
        break;
      }
      case 2:  // a lost byte
        frame.erase(frame.begin() + rng.Below(static_cast<uint32_t>(frame.size())));
        break;
      case 3:  // a changed bit
        frame[rng.Below(static_cast<uint32_t>(frame.size()))] ^=
            static_cast<uint8_t>(1 << rng.Below(8));
        break;
      case 4:  // cut off
        frame.resize(rng.Below(static_cast<uint32_t>(frame.size())));
        break;
      case 5:  // a doubled header byte
        frame.insert(frame.begin(), kHeader0);
        break;
      default:
        out.intact.push_back({out.bytes.size(), frame});
    }
    out.bytes.insert(out.bytes.end(), frame.begin(), frame.end());
  }
  return out;
}

// The found frames with their places, from pieces of random sizes.
std::vector<Stream::Truth> ParseInPieces(const std::vector<uint8_t>& bytes, CounterRng& rng,
                                         FrameParser* parser) {
  std::vector<Stream::Truth> out;
  size_t end = 0;
  const auto take = [&](std::vector<Frame> frames) {
    for (const Frame& frame : frames) {
      const auto encoded = EncodeFrame(frame.payload);
      out.push_back({end - frame.bytes_after - encoded.size(), encoded});
    }
  };
  while (end < bytes.size()) {
    const size_t n =
        std::min<size_t>(1 + rng.Below(rng.Below(2) == 0 ? 4 : 400), bytes.size() - end);
    end += n;
    take(parser->Push(std::span(bytes).subspan(end - n, n)));
  }
  take(parser->AbandonPartial());
  return out;
}

TEST(KobukiResync, EveryIntactFrameIsFoundWhateverStandsBetween) {
  size_t intact = 0;
  size_t total_bytes = 0;
  for (uint64_t i = 0; total_bytes < 10'000'000; ++i) {
    CounterRng rng(2, 3, i);
    const Stream stream = DamagedStream(rng, 400);
    total_bytes += stream.bytes.size();
    FrameParser parser;
    const auto found = ParseInPieces(stream.bytes, rng, &parser);
    for (const auto& frame : found) {  // the frame stands at its place, byte by byte
      ASSERT_TRUE(std::equal(frame.bytes.begin(), frame.bytes.end(),
                             stream.bytes.begin() + static_cast<ptrdiff_t>(frame.begin)));
    }
    const auto begins_at = [](size_t begin) {
      return [begin](const auto& frame) { return frame.begin == begin; };
    };
    for (const auto& truth : stream.intact) {
      ASSERT_TRUE(std::any_of(found.begin(), found.end(), begins_at(truth.begin)))
          << "stream " << i << " byte " << truth.begin;
    }
    intact += stream.intact.size();
    EXPECT_EQ(parser.counters().bytes, static_cast<int64_t>(stream.bytes.size()));
    EXPECT_FALSE(parser.has_partial());
  }
  RecordProperty("intact_frames", std::to_string(intact));
  EXPECT_GT(intact, 50'000);
}

TEST(KobukiResync, PiecesDoNotMatter) {
  for (uint64_t i = 0; i < 200; ++i) {
    CounterRng rng(2, 4, i);
    const Stream stream = DamagedStream(rng, 50);
    FrameParser whole;
    FrameParser pieces;
    const auto a = ParseAll(stream.bytes, &whole);
    const auto b = ParseInPieces(stream.bytes, rng, &pieces);
    ASSERT_EQ(a.size(), b.size());
    for (size_t k = 0; k < a.size(); ++k) EXPECT_EQ(EncodeFrame(a[k].payload), b[k].bytes);
    EXPECT_EQ(whole.counters().skipped_bytes, pieces.counters().skipped_bytes);
    EXPECT_EQ(whole.counters().bad_checksum, pieces.counters().bad_checksum);
  }
}

TEST(KobukiResync, LostByteCostsOneFrame) {
  CounterRng rng(2, 5, 0);
  for (int lost = 0; lost < 80; ++lost) {
    std::vector<uint8_t> bytes;
    std::vector<Feedback> sent;
    for (int k = 0; k < 8; ++k) {
      sent.push_back(RandomFeedback(rng, true));
      auto frame = EncodeFrame(EncodeFeedback(sent.back()));
      if (k == 3) frame.erase(frame.begin() + lost);
      bytes.insert(bytes.end(), frame.begin(), frame.end());
    }
    sent.erase(sent.begin() + 3);
    const auto frames = ParseAll(bytes);
    ASSERT_EQ(frames.size(), sent.size()) << "byte " << lost;
    for (size_t k = 0; k < sent.size(); ++k) {
      EXPECT_EQ(DecodeFeedback(frames[k].payload), sent[k]);
    }
  }
}

TEST(KobukiResync, RandomBytesHarmNothing) {
  FrameParser parser;
  int64_t decoded = 0;
  for (uint64_t i = 0; i < 20'000; ++i) {
    CounterRng rng(2, 6, i);
    std::vector<uint8_t> bytes(rng.Below(512));
    for (uint8_t& b : bytes) {
      // Most bytes mean something to the parser.
      constexpr uint8_t kFavourites[] = {0xAA, 0x55, 0x03, 0x01, 0x00, 0x0D, 0xC8, 0xFF};
      b = rng.Below(2) == 0 ? kFavourites[rng.Below(8)] : Byte(rng);
    }
    for (const Frame& frame : parser.Push(bytes)) {
      DecodeFeedback(frame.payload);
      DecodeCommands(frame.payload);
      ++decoded;
    }
    // These are payloads that no parser vouches for.
    DecodeFeedback(bytes);
    DecodeCommands(bytes);
  }
  const FrameCounters& c = parser.counters();
  EXPECT_EQ(c.frames, decoded);
  EXPECT_GT(c.bytes, 5'000'000);
  EXPECT_GT(c.bad_checksum, 0);
  EXPECT_GT(c.bad_length, 0);
  EXPECT_GT(c.malformed, 0);
}

}  // namespace
}  // namespace gw::kobuki

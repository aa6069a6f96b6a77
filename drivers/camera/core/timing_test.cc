// Tests of the times of images and IMU samples.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/core/random.h"
#include "drivers/camera/core/frame_clock.h"
#include "drivers/camera/core/imu_merger.h"

namespace gw::camera {
namespace {

constexpr int64_t kPeriodUs = 33'333;
constexpr uint32_t kExposureUs = 8'000;

// A camera whose clock runs fast, behind a link that delays each frame at random. The camera
// stamps the end of the exposure.
class Stream {
 public:
  Stream(uint32_t first_pts_us, double ppm) : first_pts_us_(first_pts_us), ppm_(ppm) {}

  RawFrame Next() {
    ++sequence_;
    CounterRng rng(7, 1, sequence_);
    const int64_t device = std::llround(static_cast<double>(true_us()) * (1 + ppm_ * 1e-6));
    RawFrame frame;
    frame.sequence = sequence_;
    frame.metadata = FrameMetadata{};
    frame.metadata->pts_us = first_pts_us_ + static_cast<uint32_t>(device);
    frame.arrival =
        Utime{kStartUs + true_us()} + DurationUs{std::llround(-4000 * std::log(1 - rng.Uniform()))};
    return frame;
  }
  void Skip(uint32_t frames) { sequence_ += frames; }
  int64_t true_us() const { return kPeriodUs * sequence_; }
  Utime mid_exposure() const { return Utime{kStartUs + true_us()} - DurationUs{kExposureUs / 2}; }

 private:
  static constexpr int64_t kStartUs = 1'700'000'000'000'000;
  uint32_t first_pts_us_;
  double ppm_;
  uint32_t sequence_ = 0;
};

TEST(FrameClock, MidExposureWithinAMillisecondAcrossTheWrapOf71Minutes) {
  // The camera's clock wraps 20 s after the start.
  Stream stream(UINT32_MAX - 20'000'000, 60);
  FrameClock clock{{}};
  double worst_ms = 0;
  int stamped = 0;
  for (int i = 0; i < 1800; ++i) {
    const RawFrame frame = stream.Next();
    const auto stamp = clock.Add(frame, kExposureUs);
    if (!stamp) continue;
    ++stamped;
    if (i < 90) continue;
    const DurationUs error = stamp->mid_exposure - stream.mid_exposure();
    worst_ms = std::max(worst_ms, std::abs(error.seconds()) * 1e3);
  }
  EXPECT_GE(stamped, 1800 - 20);  // all but the first half second
  EXPECT_LT(worst_ms, 1.0);       // arrivals wait 4 ms on average, up to 30 ms
  EXPECT_EQ(clock.restarts(), 0);
  EXPECT_EQ(clock.device_clock().steps(), 0);
  std::printf("worst %.3f ms\n", worst_ms);
}

TEST(FrameClock, TwoWrapsInThreeHours) {
  Stream stream(123, -20);
  FrameClock clock{{}};
  Utime last{0};
  for (int64_t i = 0; i < 3 * 3600 * 30 / 10; ++i) {  // three frames a second
    const RawFrame frame = stream.Next();
    stream.Skip(9);
    const auto stamp = clock.Add(frame, 0);
    if (!stamp) continue;
    ASSERT_GT(stamp->mid_exposure, last);
    if (last.us > 0) {
      ASSERT_NEAR(static_cast<double>((stamp->mid_exposure - last).us), 10. * kPeriodUs, 20'000);
    }
    last = stamp->mid_exposure;
  }
  EXPECT_EQ(clock.restarts(), 0);
}

TEST(FrameClock, MetadataKnowTheExposureBetter) {
  Stream stream(0, 0);
  FrameClock clock{Milliseconds(3)};
  for (int i = 0; i < 100; ++i) {
    RawFrame frame = stream.Next();
    frame.arrival = Utime{stream.true_us()};
    frame.metadata->exposure_us = 4000;
    frame.metadata->to_mid_exposure_us = 2100;
    const auto stamp = clock.Add(frame, kExposureUs);
    if (!stamp) continue;
    EXPECT_EQ(stamp->exposure_us, 4000);
    EXPECT_NEAR(static_cast<double>(stamp->mid_exposure.us),
                static_cast<double>(stream.true_us() - 2100 - 3000), 2);
  }
}

TEST(FrameClock, FramesWithoutMetadataCountOn) {
  Stream stream(5, 0);
  FrameClock clock{{}};
  int stamped = 0;
  for (int i = 0; i < 300; ++i) {
    RawFrame frame = stream.Next();
    if (i > 100 && i % 3 != 0) frame.metadata.reset();
    const auto stamp = clock.Add(frame, kExposureUs);
    if (i < 100 || !stamp) continue;
    ++stamped;
    EXPECT_NEAR((stamp->mid_exposure - stream.mid_exposure()).seconds(), 0, 1e-3);
  }
  EXPECT_EQ(stamped, 200);
  // The counting on does not last for ever: the clocks drift, and frames may have been lost.
  stream.Skip(40);
  RawFrame late = stream.Next();
  late.metadata.reset();
  EXPECT_FALSE(clock.Add(late, kExposureUs));
}

TEST(FrameClock, CameraThatResetItsClockIsFollowedAfterAWarmUp) {
  FrameClock clock{{}};
  Stream before(1'000'000'000, 0);
  for (int i = 0; i < 60; ++i) (void)clock.Add(before.Next(), 0);
  Stream after(1'000, 0);
  after.Skip(100);  // frames are skipped so that arrivals go on
  int stamped = 0;
  for (int i = 0; i < 60; ++i) {
    const auto stamp = clock.Add(after.Next(), kExposureUs);
    if (!stamp) continue;
    ++stamped;
    EXPECT_NEAR((stamp->mid_exposure - after.mid_exposure()).seconds(), 0, 4e-3);
  }
  EXPECT_EQ(clock.restarts(), 1);
  EXPECT_GE(stamped, 60 - 20);
}

TEST(FrameClock, WithoutAnyMetadataArrivalsLessHalfTheExposure) {
  FrameClock clock{Milliseconds(2)};
  RawFrame frame;
  frame.arrival = {1'000'000};
  const auto stamp = clock.Add(frame, 10'000);
  ASSERT_TRUE(stamp);
  EXPECT_EQ(stamp->mid_exposure.us, 1'000'000 - 5'000 - 2'000);
  EXPECT_FALSE(clock.Add(frame, 10'000)) << "time must go on";
}

// The gyro has 200 Hz and the accelerometer 63 Hz, and both are linear in time.
TEST(ImuMerger, AccelerometerIsInterpolatedToTheGyro) {
  ImuMerger merger;
  std::vector<ImuSample> out;
  const auto take = [&out](std::vector<ImuSample> samples) {
    out.insert(out.end(), samples.begin(), samples.end());
  };
  int64_t next_accel = 3'000;
  for (int64_t t = 0; t < 1'000'000; t += 5'000) {
    while (next_accel <= t) {
      take(merger.AddAccel({{next_accel}, Eigen::Vector3d(1e-6, 2e-6, -1e-6) * next_accel}));
      next_accel += 15'873;
    }
    take(merger.AddGyro({{t}, Eigen::Vector3d::Constant(1e-6 * static_cast<double>(t))}));
  }
  ASSERT_GT(out.size(), 190U);
  EXPECT_EQ(merger.without_accel(), 1);  // the first sample comes before any of the accelerometer
  for (size_t i = 0; i < out.size(); ++i) {
    EXPECT_EQ(out[i].seq, static_cast<int64_t>(i) + 1);
    EXPECT_EQ(out[i].utime.us, 5'000 * static_cast<int64_t>(i));
    if (i == 0) continue;
    ASSERT_TRUE(out[i].has_accel);
    const double t = out[i].utime.seconds();
    EXPECT_TRUE(out[i].a_I_m_s2.isApprox(Eigen::Vector3d(t, 2 * t, -t), 1e-9));
    EXPECT_NEAR(out[i].w_I_rad_s.x(), t, 1e-12);
  }
}

TEST(ImuMerger, SilentAccelerometerDoesNotStopTheGyro) {
  ImuMerger merger;
  size_t samples = 0;
  for (int64_t t = 0; t < 1'000'000; t += 5'000) {
    const auto out = merger.AddGyro({{t}, Eigen::Vector3d::Zero()});
    for (const ImuSample& sample : out) EXPECT_FALSE(sample.has_accel);
    samples += out.size();
  }
  EXPECT_EQ(samples, 200U - 13);
  EXPECT_EQ(merger.without_accel(), 187);
}

TEST(ImuMerger, SamplesThatGoBackAreDropped) {
  ImuMerger merger;
  (void)merger.AddAccel({{0}, {}});
  (void)merger.AddAccel({{10'000}, {}});
  EXPECT_EQ(merger.AddGyro({{5'000}, {}}).size(), 1U);
  EXPECT_TRUE(merger.AddGyro({{5'000}, {}}).empty());
  EXPECT_TRUE(merger.AddGyro({{4'000}, {}}).empty());
  EXPECT_TRUE(merger.AddAccel({{10'000}, {}}).empty());
  EXPECT_EQ(merger.dropped(), 3);
}

}  // namespace
}  // namespace gw::camera

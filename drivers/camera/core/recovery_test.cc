#include "drivers/camera/core/recovery.h"

#include <gtest/gtest.h>

#include <vector>

namespace gw::camera {
namespace {

Utime Ms(int64_t ms) {
  return Utime{} + Milliseconds(ms);
}

// The remedies, and their times, for a device that starts but never delivers.
TEST(Recovery, LadderOfADeadDevice) {
  Recovery recovery;
  std::vector<Remedy> tried;
  std::vector<int64_t> at_ms;
  recovery.Started(Ms(0));
  for (int64_t ms = 0; ms < 120'000; ms += 20) {
    const Remedy remedy = recovery.Next(Ms(ms));
    if (remedy == Remedy::kNone) continue;
    tried.push_back(remedy);
    at_ms.push_back(ms);
    if (remedy == Remedy::kGiveUp) break;
    recovery.Started(Ms(ms));
  }
  const Remedy r = Remedy::kRestartStream, u = Remedy::kResetUsb;
  EXPECT_EQ(tried, (std::vector<Remedy>{r, r, r, u, r, r, r, u, r, r, r, Remedy::kGiveUp}));
  EXPECT_EQ(at_ms.front(), 3020);
  EXPECT_LT(at_ms.back(), 40'000);
  EXPECT_EQ(recovery.restarts(), 9);
  EXPECT_EQ(recovery.resets(), 2);
}

TEST(Recovery, SilenceInTheStreamIsSeenAfterASecond) {
  Recovery recovery;
  recovery.Started(Ms(0));
  for (int64_t ms = 0; ms < 2000; ms += 33) {
    recovery.Frame(Ms(ms));
    ASSERT_EQ(recovery.Next(Ms(ms)), Remedy::kNone);
  }
  for (int64_t ms = 2000; ms < 2960; ms += 20) ASSERT_EQ(recovery.Next(Ms(ms)), Remedy::kNone);
  EXPECT_EQ(recovery.Next(Ms(3000)), Remedy::kRestartStream);
  EXPECT_EQ(recovery.Next(Ms(3020)), Remedy::kNone) << "given once until it is started again";
}

// A computer that was busy elsewhere finds no new frames when it comes back; they come then.
TEST(Recovery, OwnSleepIsNoSilenceOfTheCamera) {
  Recovery recovery;
  recovery.Started(Ms(0));
  recovery.Frame(Ms(100));
  EXPECT_EQ(recovery.Next(Ms(100)), Remedy::kNone);
  EXPECT_EQ(recovery.Next(Ms(2100)), Remedy::kNone);
  for (int64_t ms = 2120; ms < 3080; ms += 20) ASSERT_EQ(recovery.Next(Ms(ms)), Remedy::kNone);
  EXPECT_EQ(recovery.Next(Ms(3120)), Remedy::kRestartStream);
}

TEST(Recovery, ErrorsActAtOnceButAFailedStartIsNotRepeatedInALoop) {
  Recovery recovery;
  recovery.Started(Ms(0));
  recovery.Failed();
  for (int64_t ms = 0; ms <= 500; ms += 100) ASSERT_EQ(recovery.Next(Ms(ms)), Remedy::kNone);
  EXPECT_EQ(recovery.Next(Ms(520)), Remedy::kRestartStream);
  recovery.Started(Ms(520));
  recovery.Frame(Ms(700));
  EXPECT_EQ(recovery.Next(Ms(720)), Remedy::kNone);
  recovery.Frame(Ms(900));
  EXPECT_EQ(recovery.Next(Ms(1000)), Remedy::kNone);
  recovery.Failed();
  EXPECT_EQ(recovery.Next(Ms(1200)), Remedy::kRestartStream);
}

TEST(Recovery, GoodSecondsBeginTheLadderAnew) {
  Recovery recovery;
  for (int round = 0; round < 20; ++round) {
    const int64_t begin = round * 10'000;
    recovery.Started(Ms(begin));
    for (int64_t ms = 0; ms < 4'000; ms += 100) {
      recovery.Frame(Ms(begin + ms));
      ASSERT_EQ(recovery.Next(Ms(begin + ms)), Remedy::kNone);
    }
    recovery.Failed();
    ASSERT_EQ(recovery.Next(Ms(begin + 4'000)), Remedy::kRestartStream) << round;
  }
}

TEST(Recovery, AbsenceIsNoFailure) {
  Recovery recovery;
  recovery.Started(Ms(0));
  recovery.Failed();
  recovery.Gone();
  EXPECT_EQ(recovery.Next(Ms(60'000)), Remedy::kNone);
}

}  // namespace
}  // namespace gw::camera

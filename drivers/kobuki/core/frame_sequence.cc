#include "drivers/kobuki/core/frame_sequence.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace gw::kobuki {
namespace {

int64_t StepMs(const FrameStamp& before, const FrameStamp& after) {
  return static_cast<uint16_t>(after.timestamp_ms - before.timestamp_ms);
}

int64_t HostMs(const FrameStamp& before, const FrameStamp& after) {
  return (after.arrival - before.arrival).us / 1000;
}

// True when a motion of this base can change the ticks by this much in the time between. A repeated
// time may come with the ticks of the next frame.
bool TicksFit(uint16_t before, uint16_t after, int64_t step_ms) {
  const int ticks = static_cast<int16_t>(static_cast<uint16_t>(after - before));
  const auto step = static_cast<double>(std::max<int64_t>(step_ms, 20));
  return std::abs(ticks) <= FrameSequence::kMaxTicksPerMs * step + 10;
}

}  // namespace

bool FrameSequence::Follows(const FrameStamp& before, const FrameStamp& after) {
  const int64_t step = StepMs(before, after);
  const int64_t host = HostMs(before, after);
  return step <= kMaxGapMs && step <= host + kMaxEarlyMs && host <= step + kMaxLateMs &&
         TicksFit(before.left_ticks, after.left_ticks, step) &&
         TicksFit(before.right_ticks, after.right_ticks, step);
}

FrameSequence::Judgement FrameSequence::Judge(const FrameStamp& stamp) {
  if (last_ && Follows(*last_, stamp)) {
    corrupt_ += suspect_.has_value();
    suspect_.reset();
    const int64_t step = StepMs(*last_, stamp);
    if (step == 0) return {Verdict::kDuplicate, robot_us_, false};
    robot_us_ += 1000 * step;
    last_ = stamp;
    return {Verdict::kContinues, robot_us_, false};
  }
  // Two frames that fit each other outvote what was before.
  if (!suspect_ || !Follows(*suspect_, stamp) || StepMs(*suspect_, stamp) == 0) {
    corrupt_ += suspect_.has_value();
    suspect_ = stamp;
    return {};
  }
  Judgement out{Verdict::kRestarts, 0, false};
  if (last_) {
    constexpr double kTurnMs = 65536;
    const int64_t host = HostMs(*last_, stamp);
    const int64_t step = StepMs(*last_, stamp);
    const double turns = std::round(static_cast<double>(host - step) / kTurnMs);
    const int64_t unwrapped = step + static_cast<int64_t>(turns * kTurnMs);
    const int64_t lateness = host - unwrapped;
    out.rebooted = unwrapped <= 0 || lateness < -kMaxEarlyMs || lateness > kMaxLateMs;
    out.robot_us = out.rebooted ? 0 : robot_us_ + 1000 * unwrapped;
    ++restarts_;
    reboots_ += out.rebooted;
  }
  robot_us_ = out.robot_us;
  last_ = stamp;
  suspect_.reset();
  return out;
}

}  // namespace gw::kobuki

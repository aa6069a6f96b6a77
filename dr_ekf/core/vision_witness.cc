#include "dr_ekf/core/vision_witness.h"

#include <algorithm>
#include <cmath>

#include "common/good_weights/quality.h"

namespace gw::dr_ekf {
namespace {

constexpr DurationUs kWindow = Milliseconds(200);
constexpr DurationUs kMemory = Milliseconds(1000);  // of the wheels' way, for late images
constexpr double kLeastWatched = 0.12;              // s of the window that must have been seen
constexpr DurationUs kMaxImageGap = Milliseconds(150);
constexpr size_t kMaxWaiting = 32;

// Wheels and vision agree to a few percent and centimetres per second where both are well: 2 mm in
// each pose and 1 cm/sqrt(m) of the wheels are 0.02 m/s over the window. From these on the wheels
// are accused. A slip at twice the true speed is a half.
constexpr double kLeastExcess = 0.07;       // m/s
constexpr double kLeastExcessShare = 0.25;  // of the faster one
// A rolling robot goes where it looks. Vision that sees it go sideways or up this much, as a share
// of what it holds against the wheels, is not to be believed either.
constexpr double kMaxAside = 0.5;
// A slip is over after some seconds, or the robot stands (vision below this share of the wheels).
// Wheels that go on to tell another way than vision have a wrong scale: the front-end measures it,
// which it cannot while they are said to slip.
constexpr DurationUs kLongestSlip = Milliseconds(5000);
constexpr double kStands = 0.1;

}  // namespace

void VisionWitness::Clear() {
  *this = VisionWitness(T_BC_);
}

double VisionWitness::WayAt(Utime utime) const {
  const auto after = std::lower_bound(ways_.begin(), ways_.end(), utime,
                                      [](const WayPoint& p, Utime t) { return p.utime < t; });
  if (after == ways_.begin()) return after->way_m;
  const auto before = std::prev(after);
  const double f = (utime - before->utime).seconds() / (after->utime - before->utime).seconds();
  return before->way_m + f * (after->way_m - before->way_m);
}

std::optional<VisionVerdict> VisionWitness::Push(const WheelSample& sample, double wheel_scale) {
  if (ways_.empty() || sample.utime_begin != ways_.back().utime) {
    if (!ways_.empty() && sample.utime <= ways_.back().utime) return std::nullopt;
    Clear();  // the way between is not known
    ways_.push_back({sample.utime_begin, 0});
  }
  const double way = std::copysign(std::hypot(sample.dx_m, sample.dy_m), sample.dx_m);
  ways_.push_back({sample.utime, ways_.back().way_m + wheel_scale * way});
  while (ways_.back().utime - ways_.front().utime > kMemory) ways_.pop_front();
  return TakeCovered();
}

std::optional<VisionVerdict> VisionWitness::Push(const FramePose& frame) {
  waiting_.push_back(frame);
  if (waiting_.size() > kMaxWaiting) waiting_.pop_front();
  return TakeCovered();
}

// Beside the same keyframe the pose stands wherever the map moves that; at ten images a second
// nearly each comes with a map of its own.
std::optional<SE3> VisionWitness::MotionBetween(const FramePose& a, const FramePose& b) const {
  if (a.map_revision == b.map_revision) return a.T_WB.inverse() * b.T_WB;
  if (!a.reference_keyframe.valid() || a.reference_keyframe != b.reference_keyframe) {
    return std::nullopt;
  }
  return T_BC_ * a.T_KC.inverse() * b.T_KC * T_BC_.inverse();
}

std::optional<VisionVerdict> VisionWitness::TakeCovered() {
  std::optional<VisionVerdict> verdict;
  while (!waiting_.empty() && !ways_.empty() && waiting_.front().utime <= ways_.back().utime) {
    const FramePose frame = waiting_.front();
    waiting_.pop_front();
    if (last_ && frame.utime <= last_->utime) continue;
    const std::optional<FramePose> before = last_;
    last_.reset();
    if (frame.utime < ways_.front().utime || !VisionMayJudgeDr(frame) || !frame.T_WB.IsFinite() ||
        !frame.T_KC.IsFinite()) {
      steps_.clear();
      suspected_ = false;
      accused_since_.reset();
      continue;
    }
    last_ = frame;
    if (!before || before->utime < ways_.front().utime ||
        frame.utime - before->utime > kMaxImageGap) {
      continue;
    }
    const std::optional<SE3> T_ab = MotionBetween(*before, frame);
    if (!T_ab) continue;
    const Eigen::Quaterniond half_back = ExpSO3(-0.5 * LogSO3(T_ab->rotation()));
    steps_.push_back({frame.utime, (frame.utime - before->utime).seconds(),
                      WayAt(frame.utime) - WayAt(before->utime), half_back * T_ab->translation()});
    while (frame.utime - steps_.front().end > kWindow) steps_.pop_front();
    verdict = Judge();
  }
  return verdict;
}

std::optional<VisionVerdict> VisionWitness::Judge() {
  double duration = 0, wheels = 0;
  Eigen::Vector3d vision = Eigen::Vector3d::Zero();
  for (const Step& step : steps_) {
    duration += step.duration_s;
    wheels += step.wheels_m;
    vision += step.vision_m;
  }
  if (duration < kLeastWatched) return std::nullopt;
  const double excess = (wheels - vision.x()) / duration;
  const double fastest = std::max(std::abs(wheels), std::abs(vision.x())) / duration;
  const double limit = std::max(kLeastExcess, kLeastExcessShare * fastest);
  if (std::abs(excess) < 0.5 * limit) {
    suspected_ = false;
    accused_since_.reset();
    return VisionVerdict{true, excess};
  }
  const double aside = vision.tail<2>().cwiseAbs().maxCoeff() / duration;
  const bool suspected_before = suspected_;
  suspected_ = std::abs(excess) > limit && aside < kMaxAside * std::abs(excess);
  if (!suspected_ || !suspected_before) return std::nullopt;
  const Utime now = steps_.back().end;
  if (!accused_since_) accused_since_ = now;
  const bool moves = std::abs(vision.x()) > kStands * std::abs(wheels);
  if (moves && now - *accused_since_ > kLongestSlip) return std::nullopt;
  return VisionVerdict{false, excess};
}

}  // namespace gw::dr_ekf

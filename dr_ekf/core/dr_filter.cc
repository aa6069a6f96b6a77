#include "dr_ekf/core/dr_filter.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "dr_ekf/core/error_state.h"
#include "dr_ekf/core/noise_model.h"
#include "dr_ekf/core/without_accelerometer.h"

namespace gw::dr_ekf {
namespace {

constexpr DurationUs kMaxJump = Milliseconds(1000);  // ahead of everything seen so far
constexpr DurationUs kBeginSlack =
    Milliseconds(1);                             // interval begins are snapped to the end before
constexpr int64_t kMaxUtime = int64_t{1} << 61;  // differences of times cannot overflow
// A clock that was set back, not a late packet: all samples, for this long of their own time.
constexpr DurationUs kLateBeforeRestart = Milliseconds(500);
constexpr int kLateSamples = 3;

DrModel WithoutAccelerometer(const DrEkfConfig& config, Calibration calibration) {
  calibration.imu.has_accel = false;
  return DrModel(config, calibration);
}

bool IsUsable(Utime utime) {
  return utime.us > -kMaxUtime && utime.us < kMaxUtime;
}

}  // namespace

DrFilter::DrFilter(const DrEkfConfig& config, const Calibration& calibration)
    : config_(config),
      calibration_(calibration),
      model_(config, calibration),
      vision_(calibration.camera.T_BC),
      chain_(config, DurationFromSeconds(1 / calibration.wheel.rate_hz)),
      imu_check_(calibration.imu) {
  if (calibration.imu.present && calibration.imu.has_accel && calibration.wheel.present) {
    twin_ = WithoutAccelerometer(config, calibration);
  }
}

Result<DrFilter> DrFilter::Create(const DrEkfConfig& config, const Calibration& calibration) {
  if (!calibration.imu.present && !calibration.wheel.present) {
    return Error{ErrorCode::kBadConfig,
                 "calibration has neither imu.present nor wheel.present: dead reckoning needs one"};
  }
  return DrFilter(config, calibration);
}

// Late is decided by the caller; here only jumps ahead. True: go on with the sample.
bool DrFilter::CheckTime(Utime begin, Utime utime, std::optional<Utime>& suspect) {
  if (history_.empty() || utime - history_.back().after.utime <= kMaxJump) {
    suspect.reset();
    return true;
  }
  const bool confirmed = suspect && utime > *suspect && utime - *suspect <= kMaxJump;
  suspect = utime;
  if (!confirmed) {
    ++counters_.rejected_future;
    return false;
  }
  suspect.reset();
  Find(DrDiagnosis::kTimeJumpedAhead);
  Restart(begin);
  return true;
}

bool DrFilter::TakeLate(Utime begin, Utime utime) {
  ++counters_.rejected_late;
  if (consecutive_late_ == 0 || utime < late_since_) {
    consecutive_late_ = 0;
    late_since_ = utime;
  }
  if (++consecutive_late_ < kLateSamples || utime - late_since_ < kLateBeforeRestart) return false;
  --counters_.rejected_late;
  Find(DrDiagnosis::kTimeWentBack);
  Restart(begin);
  return true;
}

void DrFilter::Find(DrDiagnosis diagnosis) {
  found_.push_back(diagnosis);
}

void DrFilter::FindOnce(DrDiagnosis diagnosis) {
  if (found_once_.insert(diagnosis).second) Find(diagnosis);
}

void DrFilter::FindInState(const FilterState& state) {
  const auto once = [this](bool is, DrDiagnosis diagnosis) {
    if (is) FindOnce(diagnosis);
  };
  once(state.heading_stuck, DrDiagnosis::kHeadingStuck);
  once(state.counters.parted > 0, DrDiagnosis::kParted);
  once(state.wheels_stand, DrDiagnosis::kWheelsStand);
  once(state.wheels_contradicted, DrDiagnosis::kWheelsContradicted);
  once(state.wheel_turn_stuck && !state.wheels_stand, DrDiagnosis::kWheelTurnStuck);
  once(std::abs(state.yaw_scale - 1) > kOtherTrack &&
           state.P(kYawScale, kYawScale) < kKnownTrackSigma * kKnownTrackSigma,
       DrDiagnosis::kTrackIsOther);
  once((state.gyro_bias.cwiseAbs() -
        state.P.diagonal().segment<3>(kGyroBias).cwiseMax(0).cwiseSqrt())
               .maxCoeff() > kMostPriorSigmas * kGyroBiasPrior,
       DrDiagnosis::kGyroBiasLarge);
}

void DrFilter::Restart(Utime utime) {
  Entry base = BaseAt(utime, model_.Restarted(history_.back().after, utime));
  if (twin_) base.twin = twin_->Restarted(history_.back().twin, utime);
  RestartFrom(std::move(base));
}

DrFilter::Entry DrFilter::BaseAt(Utime utime, FilterState state) {
  return {{utime - DurationUs{1}, WheelBegin{}}, std::move(state), {}};
}

DrFilter::Entry DrFilter::FirstAt(Utime utime) const {
  Entry base = BaseAt(utime, model_.Initial(utime));
  if (twin_) base.twin = twin_->Initial(utime);
  return base;
}

// What a useless IMU did to the filter so far is not to be trusted either.
void DrFilter::GoOnWithoutImu(Utime utime) {
  const SE3 T_OB = history_.back().after.T_OS * model_.T_SB();
  calibration_.imu.present = false;
  model_ = DrModel(config_, calibration_);
  twin_.reset();
  RestartFrom(BaseAt(utime, model_.RestartedWithoutImu(history_.back().after, T_OB, utime)));
}

void DrFilter::GoOnWithoutAccelerometer() {
  const Entry& newest = history_.back();
  const TwinFrame frame = FrameOfTwin(newest.after.T_OS * model_.T_SB(), newest.twin.T_OS,
                                      config_.gate_sigma * kFloorTilt);
  for (Entry& entry : history_) entry.after = GoOnAsTwin(entry.twin, frame, entry.after);
  calibration_.imu.has_accel = false;
  model_ = *twin_;
  twin_.reset();
  counters_.resets += frame.levelled;
  FindOnce(DrDiagnosis::kAccelUnfit);
}

void DrFilter::CheckTurn(WheelSample* sample) {
  const bool reversed = imu_check_.wheels_turn_backwards();
  if (reversed) sample->dyaw_rad = -sample->dyaw_rad;
  imu_check_.Take(*sample);
  if (imu_check_.wheels_turn_backwards() == reversed) return;
  sample->dyaw_rad = -sample->dyaw_rad;
  chain_.Clear();
}

void DrFilter::RestartFrom(Entry base) {
  ++counters_.resets;
  history_.clear();
  history_.push_back(std::move(base));
  vision_.Clear();
  consecutive_late_ = 0;
  suspect_imu_.reset();
  suspect_wheel_.reset();
}

std::optional<size_t> DrFilter::Insert(Event event) {
  auto it = history_.end();
  const auto before = [](const Event& a, const Event& b) {
    return a.utime != b.utime ? a.utime < b.utime : a.rank() < b.rank();
  };
  while (it != history_.begin() && !before(std::prev(it)->event, event)) --it;
  if (it != history_.end() && !before(event, it->event)) return std::nullopt;
  const size_t index = static_cast<size_t>(it - history_.begin());
  history_.insert(it, Entry{std::move(event), {}, {}});
  return index;
}

bool DrFilter::Step(const DrModel& model, const Event& event, const FilterState& before,
                    FilterState& after) {
  after = before;
  after.transition.setIdentity();
  if (const auto* imu = std::get_if<ImuSample>(&event.sample)) {
    model.ApplyImu(*imu, after);
  } else if (const auto* wheel = std::get_if<WheelSample>(&event.sample)) {
    model.ApplyWheel(*wheel, after);
  } else if (const auto* verdict = std::get_if<VisionVerdict>(&event.sample)) {
    model.ApplyVerdict(*verdict, after);
  } else {
    model.ApplyWheelBegin(event.utime, after);
  }
  if (after.P.allFinite() && after.T_OS.IsFinite() && after.v_OS_S.allFinite()) return true;
  after = model.Restarted(before, event.utime);
  return false;
}

void DrFilter::ReplayFrom(size_t index) {
  for (size_t i = index; i < history_.size(); ++i) {
    Entry& entry = history_[i];
    const Entry& before = history_[i - 1];
    if (!Step(model_, entry.event, before.after, entry.after)) ++counters_.resets;
    if (twin_) Step(*twin_, entry.event, before.twin, entry.twin);
  }
}

DrFilter::Output DrFilter::Push(const ImuSample& raw) {
  ImuSample sample = raw;
  const bool numbers = IsUsable(sample.utime) && sample.w_I_rad_s.allFinite() &&
                       (!sample.has_accel || sample.a_I_m_s2.allFinite());
  if (!calibration_.imu.present || !numbers) {
    if (!numbers) FindOnce(DrDiagnosis::kImuNotNumbers);
    ++counters_.rejected_invalid;
    return Finish(false);
  }
  if (sample.w_I_rad_s.norm() > kMaxGyro ||
      (sample.has_accel && sample.a_I_m_s2.norm() > kMaxAccel)) {
    ++counters_.rejected_absurd;
    return Finish(false);
  }
  if (!sample.has_accel) sample.a_I_m_s2.setZero();
  sample.utime = sample.utime - DurationFromSeconds(calibration_.imu.time_offset_s);
  const std::optional<ImuSample> checked = imu_check_.Take(sample);
  if (!checked) {
    ++counters_.rejected_invalid;
    return Finish(false);
  }
  sample = *checked;
  if (!CheckTime(sample.utime, sample.utime, suspect_imu_)) return Finish(false);
  if (history_.empty()) {
    history_.push_back(FirstAt(sample.utime));
  }
  if (sample.utime <= history_.front().event.utime && !TakeLate(sample.utime, sample.utime)) {
    return Finish(false);
  }
  const bool newest = sample.utime >= history_.back().after.utime;
  const std::optional<size_t> index = Insert({sample.utime, sample});
  if (!index) {
    ++counters_.rejected_non_monotonic;
    return Finish(false);
  }
  consecutive_late_ = 0;
  ++counters_.imu_used;
  if (!newest) ++counters_.reordered;
  ReplayFrom(*index);
  return Finish(true);
}

DrFilter::Output DrFilter::Push(const WheelSample& raw) {
  WheelSample sample = raw;
  const bool numbers = IsUsable(sample.utime) && IsUsable(sample.utime_begin) &&
                       std::isfinite(sample.dx_m) && std::isfinite(sample.dy_m) &&
                       std::isfinite(sample.dyaw_rad) &&
                       (!sample.has_heading || std::isfinite(sample.heading_rad));
  if (!calibration_.wheel.present || !numbers) {
    if (!numbers) FindOnce(DrDiagnosis::kWheelsNotNumbers);
    ++counters_.rejected_invalid;
    return Finish(false);
  }
  const DurationUs offset = DurationFromSeconds(calibration_.wheel.time_offset_s);
  sample.utime = sample.utime - offset;
  sample.utime_begin = sample.utime_begin - offset;
  CheckTurn(&sample);
  const WheelChain::Link link = chain_.Add(sample);
  if (link.fate == WheelChain::Fate::kAbsurd) {
    ++counters_.rejected_absurd;
    FindOnce(absurd_wheels_.Add(sample.utime) ? DrDiagnosis::kWheelsTooFast
                                              : DrDiagnosis::kWheelsJumped);
    return Finish(false);
  }
  if (link.fate == WheelChain::Fate::kWaits) {
    ++counters_.wheel_used;
    ++counters_.wheels_waited;
    return Finish(false);
  }
  sample = link.interval;
  if (sample.utime_begin >= sample.utime) {
    ++counters_.rejected_non_monotonic;
    return Finish(false);
  }
  if (calibration_.imu.present && !imu_check_.usable() && !history_.empty()) {
    GoOnWithoutImu(sample.utime_begin);
  }
  // An interval that goes on where the history ends bridges the time between by itself.
  const bool goes_on =
      !history_.empty() && sample.utime_begin - history_.back().after.utime <= kBeginSlack;
  if (goes_on) {
    suspect_wheel_.reset();
  } else if (!CheckTime(sample.utime_begin, sample.utime, suspect_wheel_)) {
    return Finish(false);
  }
  if (history_.empty()) {
    history_.push_back(FirstAt(sample.utime_begin));
  }
  // The first interval after a start or restart reaches back before it; that alone is no loss.
  if (sample.utime_begin <= history_.front().event.utime &&
      !TakeLate(sample.utime_begin, sample.utime)) {
    return Finish(false);
  }
  if (!InsertWheel(sample)) {
    if (repeated_wheels_.Add(sample.utime)) FindOnce(DrDiagnosis::kWheelsTwice);
    ++counters_.rejected_non_monotonic;
    return Finish(false);
  }
  consecutive_late_ = 0;
  ++counters_.wheel_used;
  Apply(vision_.Push(sample, history_.back().after.wheel_scale));
  return Finish(true);
}

bool DrFilter::InsertWheel(WheelSample sample) {
  bool begins_at_an_end = false;
  for (auto it = history_.rbegin(); it != history_.rend(); ++it) {
    const auto* other = std::get_if<WheelSample>(&it->event.sample);
    if (other == nullptr) continue;
    const DurationUs slack = sample.utime_begin - other->utime;
    if (slack <= kBeginSlack && -slack <= kBeginSlack && sample.utime > other->utime) {
      sample.utime_begin = other->utime;
      begins_at_an_end = true;
    }
    if (other->utime_begin < sample.utime && sample.utime_begin < other->utime) return false;
  }
  const bool newest = sample.utime >= history_.back().after.utime;
  size_t first = history_.size();
  if (!begins_at_an_end) {
    const std::optional<size_t> begin = Insert({sample.utime_begin, WheelBegin{}});
    if (begin) first = *begin;
  }
  const std::optional<size_t> end = Insert({sample.utime, sample});
  if (!end) return false;
  if (!newest) ++counters_.reordered;
  ReplayFrom(std::min(first, *end));
  return true;
}

DrFilter::Output DrFilter::Push(const FramePose& frame) {
  Apply(vision_.Push(frame));
  return Finish(false);
}

void DrFilter::Apply(const std::optional<VisionVerdict>& verdict) {
  if (!verdict || history_.empty()) return;
  const std::optional<size_t> index = Insert({history_.back().after.utime, *verdict});
  if (index) ReplayFrom(*index);
}

DrFilter::Output DrFilter::Finish(bool publish) {
  Output out;
  if (twin_ && !history_.empty() && history_.back().after.accel_unfit) GoOnWithoutAccelerometer();
  if (publish) {
    // One state before the window stays: the base on which the oldest sample in it is applied.
    const Utime oldest = history_.back().after.utime - Milliseconds(config_.history_ms);
    while (history_.size() > 2 && history_[1].event.utime < oldest) history_.pop_front();

    DrState state = model_.Publish(history_.back().after);
    state.slip = state.slip || imu_check_.contradicts_wheels();
    const bool newer = !last_published_ || state.utime > last_published_->utime ||
                       state.reset_counter != last_published_->reset_counter;
    // The fastest live input sets the rate: wheels speak only where the IMU leaves a gap.
    bool due = std::holds_alternative<ImuSample>(history_.back().event.sample);
    if (!due) {
      due = !calibration_.imu.present || !last_published_ ||
            (state.utime - last_published_->utime).seconds() >= 2.5 / calibration_.imu.rate_hz;
    }
    if (newer && due) {
      state.seq = ++seq_;
      const DrState before = last_published_.value_or(DrState{});
      const auto changed = [&](bool was, bool is, DrEvent on, DrEvent off) {
        if (was != is) out.events.push_back(is ? on : off);
      };
      changed(before.wheels_alive, state.wheels_alive, DrEvent::kWheelsBack, DrEvent::kWheelsLost);
      changed(before.imu_alive, state.imu_alive, DrEvent::kImuBack, DrEvent::kImuLost);
      changed(before.slip, state.slip, DrEvent::kSlipBegin, DrEvent::kSlipEnd);
      changed(before.stationary, state.stationary, DrEvent::kStationaryBegin,
              DrEvent::kStationaryEnd);
      if (!before.gravity_aligned && state.gravity_aligned) out.events.push_back(DrEvent::kAligned);
      if (before.reset_counter != state.reset_counter) out.events.push_back(DrEvent::kReset);
      last_published_ = state;
      out.states.push_back(std::move(state));
    }
  }
  out.counters = counters_;
  if (!history_.empty()) {
    out.counters.step = history_.back().after.counters;
    FindInState(history_.back().after);
  }
  for (const DrDiagnosis diagnosis : imu_check_.Found()) Find(diagnosis);
  out.found = std::exchange(found_, {});
  return out;
}

}  // namespace gw::dr_ekf

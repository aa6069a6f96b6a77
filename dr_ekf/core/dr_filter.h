// Dead reckoning: IMU and wheel samples in, DR states out. An error-state Kalman filter (DrModel)
// over a bounded history of states and samples: a measurement that arrives late is put where it
// belongs and everything after it is done again, so that the result is that of the right order.
//
// Pure core: single-threaded, no clock, same input, same bytes. Sensor data can never abort it:
// what it cannot use it counts. As long as one of its inputs lives, states come out.
#pragma once

#include <deque>
#include <optional>
#include <set>
#include <variant>
#include <vector>

#include "common/camera/calibration.h"
#include "common/config/dr_ekf_config.h"
#include "common/contract/dead_reckoning.h"
#include "common/contract/samples.h"
#include "common/contract/tracking.h"
#include "common/core/result.h"
#include "dr_ekf/core/dr_diagnosis.h"
#include "dr_ekf/core/dr_model.h"
#include "dr_ekf/core/imu_check.h"
#include "dr_ekf/core/recurrence.h"
#include "dr_ekf/core/vision_witness.h"
#include "dr_ekf/core/wheel_chain.h"

namespace gw::dr_ekf {

// Since the start; each sample that is not used raises exactly one of the rejected_* counters.
struct DrCounters {
  int64_t imu_used = 0;
  int64_t wheel_used = 0;
  int64_t reordered = 0;               // late, but inside the history: used
  int64_t rejected_invalid = 0;        // NaN or infinite, or a channel that the calibration denies
  int64_t rejected_late = 0;           // older than the history
  int64_t rejected_non_monotonic = 0;  // repeats a time or overlaps an interval of its channel
  int64_t rejected_future = 0;         // jumped ahead, not confirmed by the next sample
  int64_t rejected_absurd = 0;         // faster than any such robot or sensor
  int64_t resets = 0;                  // continuity was lost: gap, clock step, numerical failure
  int64_t wheels_waited = 0;  // joined the next one: stamps too close, equal or back; also used
  StepCounters step;
};

enum class DrEvent {
  kWheelsLost,
  kWheelsBack,
  kImuLost,
  kImuBack,
  kSlipBegin,
  kSlipEnd,
  kStationaryBegin,
  kStationaryEnd,
  kAligned,
  kReset,
};

class DrFilter {
 public:
  struct Output {
    std::vector<DrState> states;  // to publish; times increase, except across a reset
    DrCounters counters;
    std::vector<DrEvent> events;     // what changed with these states
    std::vector<DrDiagnosis> found;  // wrong with the inputs, each once but for the clock's jumps
  };

  // Refuses (kBadConfig) a calibration that has neither IMU nor wheels.
  static Result<DrFilter> Create(const DrEkfConfig& config, const Calibration& calibration);

  // Samples as the drivers send them, each channel more or less in order; the time offsets of the
  // calibration are applied here, states carry camera time.
  Output Push(const ImuSample& sample);
  Output Push(const WheelSample& sample);
  // The pose of an image, as a witness of slip; it moves no state.
  Output Push(const FramePose& frame);

  // Motion from a to b (a <= b) with its exact covariance: errors of the two instants correlated
  // through the product of the filter's own transitions. Errors: an end outside the history
  // (history_ms), or a reset between them.
  Result<DrIncrement> Increment(Utime a, Utime b) const;

 private:
  struct WheelBegin {};
  struct Event {
    Utime utime;
    std::variant<ImuSample, WheelSample, WheelBegin, VisionVerdict> sample;
    // Order of events of one instant: IMU, end of a wheel interval, begin of the next, verdict.
    size_t rank() const { return sample.index(); }
  };
  struct Entry {
    Event event;
    FilterState after;
    FilterState twin;  // of model twin_, where there is one
  };

  DrFilter(const DrEkfConfig& config, const Calibration& calibration);

  // True: go on with a sample of (begin, utime]. Restarts after a confirmed jump ahead.
  bool CheckTime(Utime begin, Utime utime, std::optional<Utime>& suspect);
  void Restart(Utime utime);
  void GoOnWithoutImu(Utime utime);
  // An accelerometer that was found unfit takes with it what it has told.
  void GoOnWithoutAccelerometer();
  // Gives the wheels' sample to the check of the IMU, its turn the right way round.
  void CheckTurn(WheelSample* sample);
  static Entry BaseAt(Utime utime, FilterState state);
  Entry FirstAt(Utime utime) const;
  void RestartFrom(Entry base);
  // A sample older than the history. True: so are all for half a second of their own time, and the
  // filter began anew at `begin`.
  bool TakeLate(Utime begin, Utime utime);
  // A wheel interval, to where it belongs. False: it repeats or overlaps one.
  bool InsertWheel(WheelSample sample);
  void Find(DrDiagnosis diagnosis);
  void FindOnce(DrDiagnosis diagnosis);
  void FindInState(const FilterState& state);
  // Puts the event in order; returns its index, or none when an equal one is there.
  std::optional<size_t> Insert(Event event);
  void ReplayFrom(size_t index);
  // `after` is the state `before` advanced by one event; false: it began anew.
  static bool Step(const DrModel& model, const Event& event, const FilterState& before,
                   FilterState& after);
  // Takes effect from the newest state on: what was published stays.
  void Apply(const std::optional<VisionVerdict>& verdict);
  Output Finish(bool publish);

  DrEkfConfig config_;
  Calibration calibration_;
  DrModel model_;
  // Never uses the accelerometer, for as long as model_ does.
  std::optional<DrModel> twin_;
  VisionWitness vision_;
  std::deque<Entry> history_;         // in order; the first is the base that nothing can precede
  std::optional<Utime> suspect_imu_;  // a jump ahead that waits for confirmation
  std::optional<Utime> suspect_wheel_;
  WheelChain chain_;
  ImuCheck imu_check_;
  // Samples in a row that are older than the history, and the newest time before that.
  int consecutive_late_ = 0;
  Utime late_since_;
  std::vector<DrDiagnosis> found_;
  std::set<DrDiagnosis> found_once_;
  Recurrence repeated_wheels_, absurd_wheels_;
  std::optional<DrState> last_published_;
  int64_t seq_ = 0;
  DrCounters counters_;
};

}  // namespace gw::dr_ekf

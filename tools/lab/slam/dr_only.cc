#include "tools/lab/slam/dr_only.h"

#include <utility>

#include "common/good_weights/dr_history.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"

namespace gw::tools {
namespace {

constexpr DurationUs kCovariancePeriod = Milliseconds(1000);

// Keeps of the states what a DrOnlyRun holds.
class StateCollector {
 public:
  explicit StateCollector(DrOnlyRun* run) : run_(*run) {}

  void Add(const DrState& state) {
    run_.poses.push_back(
        {state.utime, state.reset_counter, state.T_OB, state.slip, run_.wheels.size()});
    const bool anew = !run_.last || state.utime <= run_.last->utime ||
                      state.reset_counter != run_.last->reset_counter;
    run_.last = state;
    if (anew) {
      history_.Clear();
      next_row_ = state.utime + kCovariancePeriod;
    }
    history_.Push(state);
    if (state.utime < next_row_) return;
    next_row_ = state.utime + kCovariancePeriod;
    DrCovarianceRow row;
    row.utime = state.utime;
    row.cov_T_OB = state.cov_T_OB;
    const auto motion = history_.Increment(state.utime - kCovariancePeriod, state.utime);
    if (motion) {
      row.motion = kCovariancePeriod;
      row.cov_motion = motion->cov;
    }
    run_.covariance.push_back(row);
  }

 private:
  DrOnlyRun& run_;
  DrHistory history_;
  Utime next_row_;
};

// One message of a channel that dead reckoning reads; counts those that cannot be decoded.
template <typename Sample>
std::optional<Sample> DecodeCounted(const process::LogEvent& event, DrOnlyRun* run) {
  auto sample = wire::Decode<Sample>(event.data);
  if (sample) return *std::move(sample);
  ++run->undecodable[std::string(event.channel)];
  return std::nullopt;
}

}  // namespace

class DrOnlyRunner::Impl {
 public:
  explicit Impl(std::optional<dr_ekf::DrFilter> filter)
      : filter_(std::move(filter)), states_(&run_) {}

  void Add(const process::LogEvent& event) {
    run_.clock.Add(event.received);
    ++run_.messages[std::string(event.channel)];
    if (event.channel == wire::kImu) {
      if (const auto sample = DecodeCounted<ImuSample>(event, &run_)) {
        run_.gyro.push_back({sample->utime, sample->w_I_rad_s, run_.wheels.size()});
        if (filter_) Take(filter_->Push(*sample));
      }
    } else if (event.channel == wire::kWheel) {
      if (const auto sample = DecodeCounted<WheelSample>(event, &run_)) {
        run_.wheels.push_back(*sample);
        if (filter_) Take(filter_->Push(*sample));
      }
    } else if (event.channel == wire::kDr && !filter_) {
      if (const auto state = DecodeCounted<DrState>(event, &run_)) states_.Add(*state);
    }
  }

  DrOnlyRun TakeRun() { return std::move(run_); }

 private:
  void Take(const dr_ekf::DrFilter::Output& output) {
    run_.counters = output.counters;
    for (const DrState& state : output.states) states_.Add(state);
    for (const dr_ekf::DrDiagnosis diagnosis : output.found) {
      run_.found.push_back({run_.last ? run_.last->utime : Utime(), diagnosis});
    }
  }

  std::optional<dr_ekf::DrFilter> filter_;
  DrOnlyRun run_;
  StateCollector states_;
};

DrOnlyRunner::DrOnlyRunner(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DrOnlyRunner::DrOnlyRunner(DrOnlyRunner&&) noexcept = default;
DrOnlyRunner::~DrOnlyRunner() = default;

Result<DrOnlyRunner> DrOnlyRunner::Create(const RobotConfig& config) {
  std::optional<dr_ekf::DrFilter> filter;
  if (config.dr_ekf.source == DrSource::kSensors) {
    auto created = dr_ekf::DrFilter::Create(config.dr_ekf, config.calibration);
    if (!created) return created.error();
    filter = std::move(*created);
  }
  return DrOnlyRunner(std::make_unique<Impl>(std::move(filter)));
}

void DrOnlyRunner::Add(const process::LogEvent& event) {
  impl_->Add(event);
}
DrOnlyRun DrOnlyRunner::Take() {
  return impl_->TakeRun();
}

Result<DrOnlyRun> RunDrOnly(process::EventLogReader& log, const RobotConfig& config,
                            const std::function<void()>& after_event) {
  auto runner = DrOnlyRunner::Create(config);
  if (!runner) return runner.error();
  while (const auto event = log.Next()) {
    runner->Add(*event);
    if (after_event) after_event();
  }
  if (log.error()) return *log.error();
  return runner->Take();
}

}  // namespace gw::tools
